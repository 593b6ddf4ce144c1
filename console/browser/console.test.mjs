// What an operator does with one robot, in a real browser at a real router.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, afterEach, before, test } from 'node:test';
import { eventually, Host, launch, launchServer, Watched } from './fixture.mjs';
import { Speed } from './speed.mjs';

const sim = 98; // a robot of sim.toml

let host;
let browser;
let speed;

before(async () => {
  host = await Host.start();
  browser = await launch();
  await host.up('sim.toml', sim);
  speed = new Speed(host, `Chassis(${sim}/0)`);
});

after(async () => {
  await browser?.close();
  await host?.end();
});

afterEach(Watched.closeAll);

const stateOf = async (name) => (await host.timsctl('component', 'status', name)).state;
const lamp = (page, name, state) => page.getByRole('button', { name: new RegExp(`^${name}: ${state}`) });

const pages = ['fleet', `robot/${sim}?tiles=Scan2d/0,Chassis/0,Position/0`, 'map', `drive/${sim}`, 'messages'];
const otherPages = [
  `plots?of=Position(${sim}/0)&curves=Position(${sim}/0).pos.x`,
  'network',
  'network?tab=links',
  'network?tab=mailboxes',
  'network?tab=clients',
  'network?tab=explain',
  'network?tab=trace',
  'network?tab=events',
  'recorder',
  'studio',
  'simulation',
];

// Of the pages, only the contrast is another in the dark; of the first ones, all is looked at.
for (const [colorScheme, rules] of [
  ['light', []],
  ['dark', ['color-contrast']],
])
  test(`every page works and is accessible, ${colorScheme}`, async () => {
    const watched = await Watched.open(browser, host, '#/fleet', { colorScheme });
    const { page } = watched;
    await page.getByRole('link', { name: `Robot ${sim}` }).waitFor();
    for (const path of [...pages, ...otherPages]) {
      await page.goto(`${host.address}/#/${path}`);
      await page.getByRole('heading', { level: 1 }).first().waitFor();
      assert.deepEqual(await watched.seriousFindings(pages.includes(path) ? [] : rules), [], path);
    }
    await watched.close(['Content Security Policy']);
  });

test('a lamp turns a component on and off', async () => {
  const watched = await Watched.open(browser, host, `#/robot/${sim}`);
  const { page } = watched;
  await lamp(page, 'Chassis/0', 'off').click();
  await lamp(page, 'Chassis/0', 'on').waitFor();
  assert.equal(await stateOf(`Chassis(${sim}/0)`), 'on');
  await lamp(page, 'Chassis/0', 'on').click();
  await lamp(page, 'Chassis/0', 'off').waitFor();
  assert.equal(await stateOf(`Chassis(${sim}/0)`), 'off');
  await watched.close();
});

test('a parameter is changed, refused and undone', async () => {
  const watched = await Watched.open(browser, host, `#/robot/${sim}?tiles=Pilot/0`);
  const { page } = watched;
  const value = async () =>
    (await host.timsctl('component', 'param', 'get', `Pilot(${sim}/0)`, 'maxSpeed')).items[0].value;
  await page.getByRole('button', { name: 'Parameters' }).click();
  const box = page.getByLabel('maxSpeed', { exact: true });
  await box.fill('700');
  assert.equal(await value(), 1000, 'nothing is sent while it is typed');
  await box.press('Enter');
  await eventually(async () => (await value()) === 700, 'the new value');
  await box.fill('-5');
  await box.press('Enter');
  await page.getByRole('alert').filter({ hasText: 'maxSpeed' }).waitFor();
  assert.equal(await value(), 700);
  await page.getByRole('button', { name: 'Undo' }).click();
  await eventually(async () => (await value()) === 1000, 'the old value');
  await watched.close();
});

async function drivingPage(options) {
  const watched = await Watched.open(browser, host, `#/drive/${sim}`, options);
  await watched.page.getByRole('button', { name: `Drive with Pilot(${sim}/0)` }).click();
  await watched.page.getByRole('button', { name: 'Release' }).waitFor();
  await watched.page.getByText(/points; the nearest/).waitFor(); // the layout is final
  await eventually(async () => (await stateOf(`Pilot(${sim}/0)`)) === 'on', 'the pilot is on');
  return watched;
}

const drives = () => speed.drives();

test('it drives while a key is held, and stands when it is released, or the page loses the focus', async () => {
  const watched = await drivingPage();
  const { page } = watched;
  await page.keyboard.down('ArrowUp');
  await drives();
  await speed.stopsBy('the key is released', () => page.keyboard.up('ArrowUp'));
  await page.keyboard.down('w');
  await drives();
  await speed.stopsBy('the focus is lost', () => page.evaluate(() => window.dispatchEvent(new Event('blur'))));
  await page.keyboard.up('w');
  await watched.close();
});

test('it drives by touch, on a phone', async () => {
  const watched = await drivingPage({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  const { page } = watched;
  const stick = page.getByRole('application', { name: /Stick/ });
  const pad = await stick.boundingBox();
  assert(pad.y + pad.height < 844, 'the whole stick is in sight');
  const ground = await page.locator('canvas.scan').evaluate((canvas) => {
    const context = canvas.getContext('2d');
    const row = (y) => [...new Uint32Array(context.getImageData(0, y, canvas.width, 1).data.buffer)];
    const [colour] = row(0);
    return row(canvas.height - 1).filter((pixel) => pixel === colour).length / canvas.width;
  });
  assert(ground > 0.5, 'the scan is painted to its last row');
  const session = await watched.context.newCDPSession(page);
  const point = { x: pad.x + pad.width / 2, y: pad.y + 10 };
  await session.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: [point] });
  await drives();
  await speed.stopsBy('the finger is lifted', () =>
    session.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] }),
  );
  await page.getByRole('button', { name: 'Release' }).click();
  await eventually(async () => (await stateOf(`Pilot(${sim}/0)`)) === 'off', 'the pilot is off');
  await watched.close();
});

test('it stands when the browser is killed', async () => {
  const [kill, other] = await launchServer();
  const watched = await Watched.open(other, host, `#/drive/${sim}`);
  await watched.page.getByRole('button', { name: `Drive with Pilot(${sim}/0)` }).click();
  await watched.page.getByRole('button', { name: 'Release' }).waitFor();
  await watched.page.keyboard.down('ArrowUp');
  await drives();
  await speed.stopsBy('the browser is killed', kill);
});

test('STOP takes the right to drive and turns the pilots off', async () => {
  const watched = await drivingPage();
  const { page } = watched;
  await page.keyboard.down('ArrowUp');
  await drives();
  await speed.stopsBy('STOP', () => page.getByRole('button', { name: `Stop robot ${sim}` }).click());
  await eventually(async () => (await stateOf(`Pilot(${sim}/0)`)) === 'off', 'the pilot is off');
  await page.keyboard.up('ArrowUp');
  await watched.close();
});

test('any other key stops it and ends its pilot', async () => {
  const watched = await drivingPage();
  const { page } = watched;
  await page.keyboard.down('ArrowUp');
  await drives();
  await speed.stopsBy('any other key', () => page.keyboard.press('x'));
  await page.getByRole('button', { name: `Drive with Pilot(${sim}/0)` }).waitFor();
  await eventually(async () => (await stateOf(`Pilot(${sim}/0)`)) === 'off', 'the pilot is off');
  await page.keyboard.up('ArrowUp');
  await watched.close();
});

test('on the map the wheel and keys zoom, Home shows all, and it turns with the robot', async () => {
  for (const name of ['Chassis', 'Odometry', 'Position']) await host.timsctl('component', 'on', `${name}(${sim}/0)`);
  const watched = await Watched.open(browser, host, '#/map');
  const { page } = watched;
  const map = page.getByRole('img', { name: /^Map of/ });
  const scale = () => map.evaluate(({ dataset }) => Number(dataset.scale));
  await page.getByText('0.00 m').first().waitFor();
  await eventually(async () => (await scale()) > 0, 'it is drawn');
  const becomes = (condition, what) => eventually(async () => condition(await scale()), what);
  const before = await scale();
  await map.hover();
  await page.mouse.wheel(0, -400);
  await becomes((now) => now > 2 * before, 'the wheel makes it larger');
  const larger = await scale();
  await map.focus();
  await page.keyboard.press('-');
  await becomes((now) => now < 0.9 * larger, 'a key makes it smaller');
  await page.keyboard.press('Home');
  await becomes((now) => Math.abs(now - before) < 0.1 * before, 'all are shown');
  await page.getByRole('button', { name: 'robot', exact: true }).click();
  await page.getByRole('button', { name: 'robot', exact: true, pressed: true }).waitFor();
  await page.keyboard.press('Escape');
  await watched.close();
});

test('on the map the right button zooms, and both bring a place into the middle', async () => {
  for (const name of ['Chassis', 'Odometry', 'Position']) await host.timsctl('component', 'on', `${name}(${sim}/0)`);
  const watched = await Watched.open(browser, host, '#/map');
  const { page } = watched;
  const map = page.getByRole('img', { name: /^Map of/ });
  const scale = () => map.evaluate(({ dataset }) => Number(dataset.scale));
  await eventually(async () => (await scale()) > 0, 'it is drawn');
  await page.getByText('0.00 m').first().waitFor();
  const mode = (name) => page.getByRole('button', { name, exact: true });
  await mode('chase').click();
  const before = await scale();
  const { x, y, width, height } = await map.boundingBox();
  await page.mouse.move(x + width / 3, y + height / 2);
  await page.mouse.down({ button: 'right' });
  await page.mouse.move(x + width / 3, y + height / 2 - 100, { steps: 5 });
  await page.mouse.up({ button: 'right' });
  await eventually(async () => (await scale()) > 1.5 * before, 'it is nearer');
  assert.equal(await mode('chase').getAttribute('aria-pressed'), 'true', 'it still follows');
  await page.mouse.down();
  await page.mouse.down({ button: 'right' });
  await eventually(async () => (await mode('world').getAttribute('aria-pressed')) === 'true', 'another place');
  await page.mouse.up({ button: 'right' });
  await page.mouse.up();
  await watched.close();
});

test('one page drives; another is told who, may stop it, and takes over by holding a button', async () => {
  const watched = await drivingPage();
  const name = await watched.page.evaluate(() => localStorage.getItem('tims.name'));
  const other = await Watched.open(browser, host, `#/drive/${sim}`);
  await other.page.getByText(`${name} drives this robot`).waitFor();
  const takeOver = other.page.getByRole('button', { name: `Take over with Pilot(${sim}/0)` });
  await takeOver.click();
  assert(await watched.page.getByRole('button', { name: 'Release' }).isVisible(), 'a click is not enough');
  await takeOver.focus();
  await other.page.keyboard.down('Enter');
  await watched.page.getByRole('alert').filter({ hasText: 'You no longer drive' }).waitFor();
  await other.page.keyboard.up('Enter');
  await other.page.getByRole('button', { name: 'Release' }).waitFor();
  await other.page.keyboard.down('ArrowUp');
  await drives();
  await speed.stopsBy('another page stops it', () =>
    watched.page.getByRole('button', { name: `Stop robot ${sim}` }).click(),
  );
  await other.page.keyboard.up('ArrowUp');
  await other.close();
  await watched.close();
});

test('the router is killed and started: the page says so, and goes on without a reload', async () => {
  const watched = await Watched.open(browser, host, `#/robot/${sim}?tiles=Position/0`);
  const { page } = watched;
  await lamp(page, 'Position/0', '(off|on)').waitFor();
  if ((await stateOf(`Position(${sim}/0)`)) === 'off') await lamp(page, 'Position/0', 'off').click();
  await page.getByText('Heading').first().waitFor();
  await page.evaluate(() => {
    globalThis.seen = {};
    const note = () => {
      const isLost = document.body.textContent.includes('No connection to the router');
      if (isLost) globalThis.seen.lost ??= Date.now();
      else if (globalThis.seen.lost !== undefined) globalThis.seen.back ??= Date.now();
    };
    new MutationObserver(note).observe(document.body, { subtree: true, childList: true });
  });
  await host.killRouter();
  const killed = Date.now();
  await page.getByRole('alert').filter({ hasText: 'No connection to the router' }).waitFor();
  await page.locator('.tile .stale').waitFor();
  await host.startRouter();
  const up = Date.now();
  await page.getByRole('alert').filter({ hasText: 'No connection' }).waitFor({ state: 'detached' });
  const { lost, back } = await page.evaluate(() => globalThis.seen);
  console.log(`lost after ${lost - killed} ms, back after ${back - up} ms`);
  assert(lost - killed < 1000, `it says so after ${lost - killed} ms`);
  assert(back - up < 2000, `it is back ${back - up} ms after the router`);
  await lamp(page, 'Position/0', 'on').waitFor();
  await page.getByText(/These data are .* old/).waitFor({ state: 'detached' });
  await watched.close(['WebSocket', 'ERR_CONNECTION_REFUSED', 'Failed to load resource']);
});

test('a page that took long to load does not take its data for old', async () => {
  await host.timsctl('component', 'on', `Position(${sim}/0)`);
  const watched = await Watched.open(browser, host, `#/robot/${sim}?tiles=Position/0`);
  const { page } = watched;
  // The worker begins as much later than its page; data are old after 2 s.
  await page.route(/\/main-.*\.js$/, (route) => setTimeout(() => route.continue(), 2500));
  await page.reload();
  const tile = page.getByRole('region', { name: 'Position/0' });
  await tile.getByText('Heading').first().waitFor();
  assert.equal(await tile.getByText(/These data are/).count(), 0);
  await watched.close();
});

test('why a message does not arrive', async () => {
  const watched = await Watched.open(browser, host, '#/network?tab=explain');
  const { page } = watched;
  await page.getByRole('combobox', { name: 'to' }).fill('Ladar(5/0)');
  await page.getByRole('button', { name: 'Explain' }).click();
  await page.getByText('knows no mailbox Ladar(5/0)').waitFor();
  await page.getByRole('combobox', { name: 'to' }).fill(`Chassis(${sim}/0)`);
  await page.getByRole('button', { name: 'Explain' }).click();
  await page.getByText(/it arrives: .* delivers it to ChassisSim/).waitFor();
  await watched.close();
});

test('texts of components arrive, and one that is repeated is one row', async () => {
  const watched = await Watched.open(browser, host, '#/messages');
  const { page } = watched;
  const name = `Odometry(${sim}/0)`;
  const turn = (verb) => host.timsctl('component', verb, name);
  await eventually(async () => {
    await turn('off');
    await turn('on');
    return (await page.getByRole('cell', { name }).count()) > 0;
  }, 'a text of the component');
  await page.getByText('Levels', { exact: true }).click();
  await page.getByLabel('Level of', { exact: true }).fill(name);
  await page.getByLabel('Level of the component').selectOption('detail');
  await page.getByRole('button', { name: 'Set', exact: true }).click();
  await page.getByText(`${name} reports up to detail.`).waitFor();
  const { items } = await host.timsctl('component', 'param', 'get', name, 'gdosLevel');
  assert.equal(items[0].value, 4);
  const saved = page.waitForEvent('download');
  await page.getByRole('button', { name: 'Save', exact: true }).click();
  assert.match(readFileSync(await (await saved).path(), 'utf8'), /Z print Odometry\(\d+\/0\) /);
  await page.getByRole('button', { name: 'Clear' }).click();
  await page.getByText('No messages yet').waitFor();
  await host.timsctl('component', 'on', `Pilot(${sim}/0)`);
  await page.goto(`${host.address}/#/robot/${sim}`);
  await page
    .getByRole('region', { name: 'Newest errors and warnings' })
    .getByText(/error: Pilot.*Joystick/)
    .waitFor();
  await host.timsctl('component', 'off', `Pilot(${sim}/0)`);
  await watched.close();
});

test('Ctrl+K goes to a component', async () => {
  const watched = await Watched.open(browser, host);
  const { page } = watched;
  await page.getByRole('link', { name: `Robot ${sim}` }).waitFor();
  await page.keyboard.press('Control+k');
  await page.keyboard.type('chas');
  await page.keyboard.press('Enter');
  await page.getByRole('region', { name: 'Chassis/0' }).waitFor();
  await page.goBack();
  await page.getByRole('heading', { name: 'Fleet' }).waitFor();
  await watched.close();
});

test('layouts are kept, and a gui.cfg is read', async () => {
  const watched = await Watched.open(browser, host, `#/robot/${sim}?tiles=Chassis/0`);
  const { page } = watched;
  const menu = page.locator('.layouts summary');
  await menu.click();
  await page.getByLabel('Name of this layout').fill('mine');
  await page.getByRole('button', { name: 'Keep this page' }).click();
  const config = `WORKSPACE drive\nrack.gui.drivers.ChassisGui 0 (1,2,3,4,0) -system=${sim}\n`;
  await page.setInputFiles('.layouts input[type=file]', {
    name: 'gui.cfg',
    mimeType: 'text/plain',
    buffer: Buffer.from(config),
  });
  await page.getByText('1 layouts read').waitFor();
  await page.reload();
  await menu.click();
  await page.getByRole('link', { name: 'mine' }).click();
  await page.getByRole('region', { name: 'Chassis/0' }).waitFor();
  await page.getByRole('link', { name: `drive (robot ${sim})` }).click();
  await page.getByRole('region', { name: 'Chassis/0' }).waitFor();
  await watched.close();
});
