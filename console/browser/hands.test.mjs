// The same work with thumbs only, on a phone, and with keys only.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { eventually, Host, launch, Watched } from './fixture.mjs';

const system = 97; // a robot of sim.toml
const phone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true };
const everyPage = [
  'fleet',
  `robot/${system}?tiles=Chassis/0,Scan2d/0,Position/0`,
  'map',
  `drive/${system}`,
  'messages',
  `plots?curves=Chassis(${system}/0).vx`,
  'network',
  'network?tab=links',
  'network?tab=mailboxes',
  `network?tab=explain&to=Chassis(${system}/0)`,
  'network?tab=trace',
  'network?tab=events',
  'studio',
  'recorder',
  'simulation',
];
const thumb = 44; // pixels, the least of what is touched

let host;
let browser;

before(async () => {
  host = await Host.start();
  browser = await launch();
  await host.up('sim.toml', system);
});

after(async () => {
  await browser?.close();
  await host?.end();
});

afterEach(Watched.closeAll);

const stateOf = async (name) => (await host.timsctl('component', 'status', name)).state;
const becomes = (name, state) => eventually(async () => (await stateOf(name)) === state, `${name} is ${state}`);
const speed = async () => (await host.timsctl('component', 'data', `Chassis(${system}/0)`)).data.vx;
// A page that has stalled on a busy machine has let the stick go: it is pressed again.
async function drivesOr(pressAgain) {
  for (let begin = Date.now(); ; await pressAgain()) {
    const drives = () => eventually(async () => (await speed()) > 50, 'it drives', 5000);
    if (
      await drives().then(
        () => true,
        () => false,
      )
    )
      return;
    assert(Date.now() < begin + 30_000, 'it never drives');
  }
}
const chassis = `Chassis(${system}/0)`;
const pilot = `Pilot(${system}/0)`;

test('thumbs: on and off, messages, driving and STOP', async () => {
  const watched = await Watched.open(browser, host, '#/fleet', phone);
  const { page } = watched;
  const tap = (role, name) => page.getByRole(role, { name }).first().tap();
  await tap('link', `Robot ${system}`);
  const lamp = (name, state) => page.getByRole('button', { name: new RegExp(`^${name}: ${state}`) });
  await lamp('Chassis/0', 'off').tap();
  await becomes(chassis, 'on');
  await lamp('Chassis/0', 'on').tap();
  await becomes(chassis, 'off');
  await tap('link', 'Messages');
  await page.getByRole('heading', { name: 'Messages' }).waitFor();
  await page.getByRole('cell', { name: chassis }).first().waitFor();
  await tap('link', 'Drive');
  await tap('link', `Robot ${system}`);
  await tap('button', `Drive with ${pilot}`);
  await page.getByRole('button', { name: 'Release' }).waitFor();
  await becomes(pilot, 'on');
  const session = await watched.context.newCDPSession(page);
  await page.getByText(/points; the nearest/).waitFor(); // the layout is final
  const press = async () => {
    const pad = await page.getByRole('application', { name: /Stick/ }).boundingBox();
    const finger = { x: pad.x + pad.width / 2, y: pad.y + pad.height / 4 };
    await session.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: [finger] });
  };
  await press();
  await drivesOr(async () => {
    await session.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
    await press();
  });
  await session.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
  await tap('button', `Stop robot ${system}`);
  await becomes(pilot, 'off');
  await page.getByText('More', { exact: true }).tap();
  await tap('link', 'Network');
  await page.getByRole('heading', { name: 'Network' }).waitFor();
  await watched.close();
});

test('thumbs: what is touched is large enough, and nothing is wider than the screen', async () => {
  const watched = await Watched.open(browser, host, '#/fleet', phone);
  const { page } = watched;
  await page.getByRole('link', { name: `Robot ${system}` }).waitFor();
  for (const path of everyPage) {
    await page.goto(`${host.address}/#/${path}`);
    await page.getByRole('heading', { level: 1 }).first().waitFor();
    const found = await page.evaluate((least) => {
      const small = [...document.querySelectorAll('button, select, summary, .button, .bar nav a')]
        .map((element) => [element.outerHTML.slice(0, 80), element.getBoundingClientRect()])
        .filter(([, { width, height }]) => width > 0 && (width < least - 0.5 || height < least - 0.5))
        .map(([html, { width, height }]) => `${html} ${width} x ${height}`);
      return { small, wide: document.documentElement.scrollWidth - innerWidth };
    }, thumb);
    assert.deepEqual(found, { small: [], wide: 0 }, path);
  }
  await watched.close();
});

// Tab until this has the focus.
async function focused(page, name) {
  for (let i = 0; i < 80; ++i) {
    const text = await page.evaluate(() => {
      const { activeElement: element } = document;
      return element?.getAttribute('aria-label') ?? element?.textContent ?? '';
    });
    if (name.test(text)) return;
    await page.keyboard.press('Tab');
  }
  assert.fail(`the Tab key does not lead to ${name}`);
}

test('keys: on and off, messages, driving and STOP', async () => {
  await host.timsctl('component', 'off', chassis);
  const watched = await Watched.open(browser, host);
  const { page } = watched;
  const { keyboard } = page;
  await page.getByRole('link', { name: `Robot ${system}` }).waitFor();
  await focused(page, new RegExp(`^Robot ${system}`));
  await keyboard.press('Enter');
  await page.getByRole('heading', { name: `Robot ${system}` }).waitFor();
  await page.getByRole('button', { name: /^Chassis\/0: off/ }).waitFor();
  await focused(page, /^Chassis\/0: off/);
  await keyboard.press('Enter');
  await becomes(chassis, 'on');
  await keyboard.press('F1'); // the view of the first component
  await page.getByRole('region', { name: 'Chassis/0' }).waitFor();
  await keyboard.press('g');
  await keyboard.press('l');
  await page.getByRole('cell', { name: chassis }).first().waitFor();
  await keyboard.press('Control+k');
  await keyboard.type(`drive robot ${system}`);
  await keyboard.press('Enter');
  await page.locator('button:enabled', { hasText: /^Drive with/ }).waitFor();
  await focused(page, /^Drive with/);
  await keyboard.press('Enter');
  await page.getByRole('button', { name: 'Release' }).waitFor();
  await becomes(pilot, 'on');
  await keyboard.down('ArrowUp');
  await drivesOr(async () => {
    await keyboard.up('ArrowUp');
    await keyboard.down('ArrowUp');
  });
  await keyboard.press('Shift+Escape');
  await becomes(pilot, 'off');
  await keyboard.up('ArrowUp');
  await watched.close();
});

test('keys: the list of them, and a filter', async () => {
  const watched = await Watched.open(browser, host);
  const { page } = watched;
  await page.getByRole('link', { name: `Robot ${system}` }).waitFor();
  await page.keyboard.press('?');
  await page.getByRole('dialog', { name: 'Keys' }).getByText('Go to a page, robot or component').waitFor();
  await page.keyboard.press('Escape');
  await page.keyboard.press('/');
  await page.keyboard.type('12345');
  await page.getByText('0 robots').waitFor();
  await watched.close();
});

test('the text is twice as large, and half; STOP stays in sight', async () => {
  const watched = await Watched.open(browser, host);
  const { page } = watched;
  for (const path of everyPage) {
    await page.goto(`${host.address}/#/${path}`);
    await page.getByRole('heading', { level: 1 }).first().waitFor();
    for (const scale of [0.5, 1, 1.25, 2]) {
      const width = Math.round(1280 / scale); // what a zoomed page has
      await page.setViewportSize({ width, height: Math.round(800 / scale) });
      const [wide, ends] = await page.evaluate(() => {
        const stop = [...document.querySelectorAll('button')].find(({ ariaLabel }) =>
          /^Stop (robot|all)/.test(ariaLabel),
        );
        return [document.documentElement.scrollWidth - innerWidth, stop.getBoundingClientRect().right];
      });
      assert(wide <= 0, `${path} at ${scale}: ${wide} pixels too wide`);
      assert(ends > 0 && ends <= width, `${path} at ${scale}: STOP ends at ${ends} of ${width}`);
    }
  }
  await watched.close();
});

// Sent at once: the page takes them one after the other.
function pressTab(session, times) {
  const tab = { key: 'Tab', code: 'Tab', windowsVirtualKeyCode: 9 };
  const events = Array.from({ length: times }, () => ['rawKeyDown', 'keyUp']).flat();
  return Promise.all(events.map((type) => session.send('Input.dispatchKeyEvent', { type, ...tab })));
}

test('keys: Tab leads to every control of every page, and on', async () => {
  const watched = await Watched.open(browser, host);
  const { page } = watched;
  const session = await watched.context.newCDPSession(page);
  await page.getByRole('link', { name: `Robot ${system}` }).waitFor();
  await page.evaluate(() => addEventListener('focusin', ({ target }) => globalThis.reached.add(target)));
  for (const path of everyPage) {
    await page.goto(`${host.address}/#/${path}`);
    await page.getByRole('heading', { level: 1 }).first().waitFor();
    const wanted = await page.evaluate(() => {
      document.activeElement?.blur();
      globalThis.reached = new Set();
      const controls = [...document.querySelectorAll('button, a[href], input, select, textarea, summary')];
      const isReached = (control) => control.checkVisibility() && !control.disabled && control.tabIndex >= 0;
      return controls.filter(isReached).filter(({ type }) => type !== 'radio').length;
    });
    await pressTab(session, wanted + 20);
    const count = await page.evaluate(() => globalThis.reached.size);
    assert(count >= wanted, `${path}: ${count} of ${wanted} controls have been reached`);
  }
  await watched.close();
});

test('back through every page, and a reload of each', async () => {
  const watched = await Watched.open(browser, host);
  const { page } = watched;
  const title = () => page.title();
  await page.getByRole('link', { name: `Robot ${system}` }).waitFor();
  const seen = [];
  for (const path of everyPage) {
    await page.evaluate((next) => (location.hash = `#/${next}`), path);
    await page.getByRole('heading', { level: 1 }).first().waitFor();
    seen.push([await page.evaluate(() => location.hash), await title()]);
    await page.reload();
    await page.getByRole('heading', { level: 1 }).first().waitFor();
    assert.deepEqual([await page.evaluate(() => location.hash), await title()], seen.at(-1), 'after a reload');
  }
  for (const [hash, name] of seen.reverse().slice(1)) {
    await page.goBack();
    await eventually(async () => (await title()) === name, `back at ${name}`);
    assert.equal(await page.evaluate(() => location.hash), hash);
    await page.getByRole('heading', { level: 1 }).first().waitFor();
  }
  await watched.close();
});

test('tiles are moved by keys, mouse and finger, and are wide; who comes again finds them so', async () => {
  const watched = await Watched.open(browser, host, `#/robot/${system}?tiles=Chassis/0,Scan2d/0,Position/0`);
  const { page } = watched;
  const names = () => page.locator('.tile').evaluateAll((tiles) => tiles.map((tile) => tile.ariaLabel).join());
  const move = (name) => page.getByRole('button', { name: `Move ${name}` });
  await move('Chassis/0').focus();
  await page.keyboard.press('ArrowRight');
  assert.equal(await names(), 'Scan2d/0,Chassis/0,Position/0');
  await page.keyboard.press('ArrowRight');
  assert.equal(await names(), 'Scan2d/0,Position/0,Chassis/0', 'it keeps the focus');
  const target = page.getByRole('heading', { name: 'Scan2d/0' });
  await move('Chassis/0').hover();
  await page.mouse.down();
  const box = await target.boundingBox();
  await page.mouse.move(box.x + 5, box.y + 5, { steps: 5 });
  await page.mouse.up();
  assert.equal(await names(), 'Chassis/0,Scan2d/0,Position/0');
  const width = async () => (await page.getByRole('region', { name: 'Chassis/0' }).boundingBox()).width;
  const before = await width();
  await page.getByRole('button', { name: 'Wide Chassis/0' }).click();
  await eventually(async () => (await width()) > 1.9 * before, 'it is wide');
  await page.keyboard.press('f');
  await page.getByRole('region', { name: 'Scan2d/0' }).waitFor({ state: 'hidden' });
  await page.keyboard.press('f');
  await page.getByRole('region', { name: 'Scan2d/0' }).waitFor();
  await page.goto(`${host.address}/#/fleet`);
  await page.getByRole('link', { name: `Robot ${system}` }).click();
  await page.getByRole('region', { name: 'Chassis/0' }).waitFor();
  assert.equal(await names(), 'Chassis/0,Scan2d/0,Position/0');
  assert((await width()) > 1.9 * before);
  await watched.close();
});

test('tiles that belong together are opened at once', async () => {
  const watched = await Watched.open(browser, host, `#/robot/${system}`);
  const { page } = watched;
  await page.getByRole('button', { name: 'Driving' }).click();
  for (const name of ['Chassis/0', 'Scan2d/0', 'Pilot/0']) await page.getByRole('region', { name }).waitFor();
  await watched.close();
});

test('two tabs, back and forward, and a reload', async () => {
  const watched = await Watched.open(browser, host, `#/robot/${system}?tiles=Chassis/0`);
  const { page, context } = watched;
  await page.getByRole('region', { name: 'Chassis/0' }).waitFor();
  const other = await context.newPage();
  await other.goto(`${host.address}/#/robot/${system}?tiles=Chassis/0,Odometry/0`);
  await other.getByRole('region', { name: 'Odometry/0' }).waitFor();
  await page.getByRole('link', { name: 'Messages' }).click();
  await page.goBack();
  await page.getByRole('region', { name: 'Chassis/0' }).waitFor();
  assert.equal(await page.getByRole('region', { name: 'Odometry/0' }).count(), 0, 'the other tab has its own tiles');
  await page.goForward();
  await page.getByRole('heading', { name: 'Messages' }).waitFor();
  await page.reload();
  await page.getByRole('heading', { name: 'Messages' }).waitFor();
  await page.getByRole('link', { name: 'Fleet' }).click();
  await page.getByRole('link', { name: `Robot ${system}` }).waitFor();
  await watched.close();
});

test('two tabs drive: the second is told who does, takes over, and the first is told', async () => {
  const watched = await Watched.open(browser, host, `#/drive/${system}`);
  const { page, context } = watched;
  await page.getByRole('button', { name: `Drive with ${pilot}` }).click();
  await page.getByRole('button', { name: 'Release' }).waitFor();
  const other = await context.newPage();
  await other.goto(`${host.address}/#/drive/${system}`);
  await other.getByText(/^Another page under your name .* drives this robot/).waitFor();
  const takeOver = await other.getByRole('button', { name: /^Take over with/ }).boundingBox();
  await other.mouse.move(takeOver.x + 20, takeOver.y + 20);
  await other.mouse.down();
  await other.getByRole('button', { name: 'Release' }).waitFor();
  await other.mouse.up();
  await page.getByText(/^You no longer drive/).waitFor();
  await other.getByRole('button', { name: 'Release' }).click();
  await page.getByRole('button', { name: `Drive with ${pilot}` }).waitFor();
  await watched.close();
});

test('two tabs show the map, each its own part of it', async () => {
  const watched = await Watched.open(browser, host, `#/map?robots=${system}`);
  const { page, context } = watched;
  const scale = (tab) => tab.getByRole('img', { name: /^Map of/ }).getAttribute('data-scale');
  await eventually(async () => (await scale(page)) !== null, 'it is drawn');
  const other = await context.newPage();
  await other.goto(`${host.address}/#/map?robots=${system}`);
  await eventually(async () => (await scale(other)) !== null, 'it is drawn, too');
  const before = await scale(page);
  await other.getByRole('button', { name: 'Zoom in' }).click();
  await eventually(async () => Number(await scale(other)) > 1.4 * Number(before), 'it is larger');
  assert.equal(await scale(page), before);
  await watched.close();
});
