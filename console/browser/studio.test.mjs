// What an operator does with the configuration of a fleet, in a real browser at real routers and agents.
import assert from 'node:assert/strict';
import { copyFileSync } from 'node:fs';
import { after, afterEach, before, test } from 'node:test';
import { ConfiguredHost, leastWindow } from './configured_host.mjs';
import { eventually, freePort, launch, Watched } from './fixture.mjs';

// Comments and all other bytes must stay.
const scout = `# The scout: what it senses, and how far.
name = "scout"
system = 1

[[component]]
program = "ChassisSim"
parameters = { vxMax = 900, targetStatus = 1 }   # mm/s

# Looks as far as the hall is long.
[[component]]
program = "Scan2dSim"
parameters = { odometrySys = "{system}", odometryInst = 0, maxRange = 8000, mapFile = "floor.dxf", targetStatus = 1 }

# Adds up what the wheels turn.
[[component]]
program = "OdometryChassis"
parameters = { chassisSys = "{system}", targetStatus = 1 }
`;
const helpers = `# What the base does for the scout.
name = "helpers"
system = 1

[[component]]
program = "DatalogRec"
`;

let base;
let robot;
let browser;

before(async () => {
  const port = await freePort();
  base = await ConfiguredHost.start(
    'base',
    `[router]\nname = "base"\nrole = "top"\n\n[udp]\nlisten = "127.0.0.1:${port}"\n\n[[link]]\nkind = "sub"\nsystem = "*"\ninterval = "200ms"\n`,
    { 'helpers.toml': helpers },
  );
  robot = await ConfiguredHost.start(
    'robot1',
    `[router]\nname = "robot1"\nsystem = 1\n\n[udp]\nlisten = "127.0.0.1:${await freePort()}"\n\n[[link]]\nkind = "super"\nto = "127.0.0.1:${port}"   # the base\nrate = "1MB"\ninterval = "200ms"\n`,
    { 'scout.toml': scout },
  );
  copyFileSync(new URL('../../deploy/robots/floor.dxf', import.meta.url), `${robot.files}/robots/floor.dxf`);
  await robot.upFile('scout.toml', 1);
  await base.upFile('helpers.toml', 1);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await robot?.end();
  await base?.end();
});

afterEach(Watched.closeAll);

async function studio(options = {}, path = '#/studio') {
  const watched = await Watched.open(browser, base, path, options);
  await node(watched.page, 'Scan2d').waitFor();
  await node(watched.page, 'DatalogRec').waitFor();
  await watched.page.getByText('No problems').waitFor();
  return watched;
}

const graph = (page) => page.getByRole('region', { name: 'Hosts and components' });
const node = (page, name) => graph(page).getByRole('button', { name: new RegExp(name) });
const tab = (page, name) => page.getByRole('tab', { name: new RegExp(`^${name}`) });

// A value in the form of a component.
async function set(page, component, parameter, value) {
  await tab(page, 'Graph').click();
  if ((await node(page, component).getAttribute('aria-pressed')) !== 'true') await node(page, component).click();
  const box = page.getByRole('complementary', { name: 'Chosen' }).getByLabel(parameter, { exact: true });
  await box.fill(value);
  await box.press('Enter');
  await tab(page, 'Changes').getByText(/\d/).waitFor();
}

async function apply(page, why, seconds = 90) {
  await tab(page, 'Changes').click();
  await page.getByLabel('Your name').fill('ada');
  await page.getByLabel('Why', { exact: true }).fill(why);
  await page.getByLabel(/Goes back unless/).selectOption(`${seconds}`);
  await page.getByRole('button', { name: /^Apply/ }).click();
  await page.getByText(`“${why}” of ada works on`).waitFor(); // that of another one may still be shown
}

const running = async (host, component, parameter) =>
  (await host.timsctl('component', 'param', 'get', component, parameter)).items[0].value;

async function keep(page) {
  await page.getByRole('button', { name: 'Keep the change' }).click();
  await page.getByText('The change is kept on').waitFor();
}

test('an edit is one line of difference, and all other bytes stay', async () => {
  const watched = await studio();
  const { page } = watched;
  await set(page, 'Scan2d', 'maxRange', '10000');
  await tab(page, 'Changes').click();
  await page.locator('.diff .added').waitFor();
  assert.deepEqual(await page.locator('.diff .added').allTextContents(), [
    '+parameters = { odometrySys = "{system}", odometryInst = 0, maxRange = 10000, mapFile = "floor.dxf", targetStatus = 1 }\n',
  ]);
  assert.equal(await page.locator('.diff .removed').count(), 1);
  await page.getByText(/Scan2dSim maxRange 8000 -> 10000 mm/).waitFor();
  assert.equal(robot.read('robots/scout.toml'), scout, 'nothing is written yet');
  await apply(page, 'see farther');
  assert.equal(robot.read('robots/scout.toml'), scout.replace('8000', '10000'));
  await eventually(
    async () => (await running(robot, 'Scan2d(1/0)', 'maxRange')) === 10000,
    'it runs with the new value',
  );
  await keep(page);
  await tab(page, 'History').click();
  await page.getByRole('heading', { name: 'see farther' }).waitFor();
  await watched.close();
});

test('what was kept is gone back to by the history', async () => {
  const watched = await studio();
  const { page } = watched;
  await tab(page, 'History').click();
  await page
    .getByRole('button', { name: /^Go back to/ })
    .last()
    .click();
  await page.locator('.diff .added').waitFor();
  await apply(page, 'as before');
  await keep(page);
  assert.equal(robot.read('robots/scout.toml'), scout);
  await watched.close();
});

test('a wrong value is refused, with its file and line', async () => {
  const watched = await studio();
  const { page } = watched;
  await set(page, 'Scan2d', 'maxRange', '-5');
  await page.getByRole('button', { name: /^1 error/ }).click();
  const line = scout.split('\n').findIndex((text) => text.includes('maxRange')) + 1;
  await page
    .getByRole('button', { name: new RegExp(`robots/scout.toml:${line}`) })
    .first()
    .click();
  const text = page.getByRole('textbox', { name: /scout.toml on robot1/ });
  await text.waitFor();
  await eventually(
    () => text.evaluate((area) => area.value.slice(area.selectionStart, area.selectionEnd).includes('maxRange = -5')),
    'the line is chosen',
  );
  await tab(page, 'Changes').click();
  assert(await page.getByRole('button', { name: /^Apply/ }).isDisabled());
  await page.getByRole('button', { name: 'Undo', exact: true }).click();
  await page.getByText('No problems').waitFor();
  await page.getByText('Nothing to apply').waitFor();
  await watched.close();
});

test('what is typed as text is in the form and the table, and cells of a spread sheet are pasted', async () => {
  const watched = await studio({}, '#/studio?view=graph');
  const { page } = watched;
  await page.goto(`${base.address}/#/studio?view=text&file=robot1%3Arobots%2Fscout.toml`);
  const text = page.getByRole('textbox', { name: /scout.toml on robot1/ });
  await text.fill((await text.inputValue()).replace('8000', '9000'));
  await page.goto(`${base.address}/#/studio?view=table&filter=Scan2d`);
  const box = page.getByLabel('maxRange of Scan2dSim on robot1');
  await eventually(async () => (await box.inputValue()) === '9000', 'the value of the text');
  await box.focus();
  await page.evaluate(() => {
    const data = new DataTransfer();
    data.setData('text/plain', 'maxRange\t7000\ntargetStatus\t0\n');
    document.activeElement.dispatchEvent(
      new ClipboardEvent('paste', { clipboardData: data, bubbles: true, cancelable: true }),
    );
  });
  await eventually(async () => (await box.inputValue()) === '7000', 'the pasted value');
  await page.goto(`${base.address}/#/studio?view=table&filter=maxRange`); // one row: Enter has none to go to
  await box.fill('7500');
  await box.press('Enter');
  await tab(page, 'Changes').getByText(/\d/).waitFor();
  await tab(page, 'Changes').click();
  await page.getByText(/maxRange = 7500, .*targetStatus = 0/).waitFor();
  await page.reload();
  await page.getByText(/maxRange = 7500, .*targetStatus = 0/).waitFor();
  await page.getByRole('button', { name: 'Discard all' }).click();
  await page.getByText('Nothing to apply').waitFor();
  await watched.close();
});

test('what is being typed is not lost when the page is drawn anew', async () => {
  const watched = await studio();
  const { page } = watched;
  await node(page, 'ChassisSim').click();
  const box = page.getByRole('complementary', { name: 'Chosen' }).getByLabel('vxMax', { exact: true });
  const drawn = page.waitForFunction(() => document.querySelector('.inspector .warn') !== null); // runs with another value
  await box.fill('77');
  await robot.timsctl('component', 'param', 'set', 'Chassis(1/0)', 'vxMax', '901');
  await drawn;
  assert.equal(await box.inputValue(), '77');
  await box.press('Escape');
  assert.equal(await box.inputValue(), '900');
  await robot.timsctl('component', 'param', 'set', 'Chassis(1/0)', 'vxMax', '900');
  await watched.close();
});

test('a change that cuts its own link is undone on all hosts by itself', async () => {
  const watched = await studio();
  const { page } = watched;
  const [router, table] = [robot.read('router.toml'), base.read('robots/helpers.toml')];
  await page.goto(`${base.address}/#/studio?view=text&file=robot1%3Arouter.toml`);
  const text = page.getByRole('textbox', { name: /router.toml on robot1/ });
  await text.fill((await text.inputValue()).replace(/to = "127.0.0.1:\d+"/, 'to = "127.0.0.1:9"'));
  await page.goto(`${base.address}/#/studio?view=text&file=base%3Arobots%2Fhelpers.toml`);
  const other = page.getByRole('textbox', { name: /helpers.toml on base/ });
  await other.fill(`${await other.inputValue()}# one more line\n`);
  await apply(page, 'cut it', leastWindow);
  assert(robot.read('router.toml').includes('127.0.0.1:9"'));
  await page.getByText(/robot1: it cannot be reached/).waitFor();
  await eventually(
    () => robot.read('router.toml') === router && base.read('robots/helpers.toml') === table,
    'both hosts are back',
  );
  await page.getByText(/went back to the files before the change/).waitFor();
  // What went back is offered again, as a draft.
  await tab(page, 'Changes').click();
  await page.getByRole('button', { name: 'Discard all' }).click();
  await watched.close();
});

test('two tabs edit: each keeps its own draft, the second one is told of the first, and merges', async () => {
  const watched = await studio();
  const [first, second] = [watched.page, await watched.context.newPage()];
  await second.goto(`${base.address}/#/studio`);
  await node(second, 'Scan2d').waitFor();
  await second.getByText('No problems').waitFor();
  await set(second, 'Scan2d', 'maxRange', '7500');
  await set(first, 'ChassisSim', 'vxMax', '800');
  await second.reload();
  await tab(second, 'Changes').click();
  await second.locator('.diff .added').filter({ hasText: 'maxRange = 7500' }).waitFor();
  assert.equal(await second.locator('.diff .added').count(), 1, 'only its own');
  await apply(first, 'slower');
  await second.getByText('“slower”').waitFor(); // counted down at each console
  const other = await Watched.open(browser, robot);
  await other.page.getByText(/“slower” of ada works on robot1; without a decision/).waitFor();
  await other.close();
  await keep(first);
  const conflict = second.getByRole('region', { name: /^Conflict/ });
  await conflict.getByText(/changed by another editor/).waitFor();
  assert(await second.getByRole('button', { name: /^Apply/ }).isDisabled(), 'nothing is written over');
  await conflict.getByRole('button', { name: 'Merge' }).click();
  await tab(second, 'Changes').click();
  await second.locator('.diff .added').waitFor();
  assert.equal(await second.locator('.diff .added').count(), 1);
  await apply(second, 'not so far');
  await keep(second);
  assert.equal(robot.read('robots/scout.toml'), scout.replace('900', '800').replace('8000', '7500'));
  await watched.close();
});

test('an agent that is killed before the change is kept goes back', async () => {
  const watched = await studio();
  const { page } = watched;
  const before = robot.read('robots/scout.toml');
  await set(page, 'Scan2d', 'maxRange', '6000');
  await apply(page, 'killed');
  await robot.killAgent();
  assert.notEqual(robot.read('robots/scout.toml'), before);
  await robot.startAgent();
  await eventually(() => robot.read('robots/scout.toml') === before, 'the file is back');
  await page.getByText(/went back/).waitFor();
  await tab(page, 'Changes').click();
  await page.getByRole('button', { name: 'Discard all' }).click();
  await watched.close();
});

test('the budgets are what the links carry', async () => {
  const watched = await studio({}, '#/studio?view=graph');
  const { page } = watched;
  base.run('timsctl', ['msg', 'echo', 'Scan2d/1/0']); // so that there is something to carry
  await tab(page, 'Links').click();
  const row = page.getByRole('row', { name: /robot1 → base/ });
  await row.waitFor();
  const wire = async () => {
    const { items } = await robot.timsctl('link', 'show');
    return items.find(({ name }) => name === 'base').wire_bytes_out;
  };
  const units = { B: 1, kB: 1e3, MB: 1e6 };
  const bytes = (text) => {
    const [, number, unit] = text.match(/^([\d.]+) (\w+)\/s/) ?? [];
    return Number(number) * units[unit];
  };
  await eventually(async () => {
    const [start, begun] = [Date.now(), await wire()];
    await new Promise((resolve) => setTimeout(resolve, 2000));
    const rate = (1000 * ((await wire()) - begun)) / (Date.now() - start);
    const shown = bytes(await row.getByRole('cell').nth(2).textContent());
    return Math.abs(shown - rate) <= 0.1 * rate;
  }, 'the same as of link show, within 10 %');
  await watched.close();
});

test('a component moves to another host, with its comments', async () => {
  const watched = await studio();
  const { page } = watched;
  const from = robot.read('robots/scout.toml');
  await node(page, 'OdometryChassis').click();
  await page.getByText('Move to …').click();
  await page.getByRole('button', { name: /^base/ }).last().click();
  await page.getByRole('heading', { name: /helpers.toml/ }).waitFor();
  const block = from.slice(from.indexOf('# Adds up'));
  await apply(page, 'to the base');
  assert.equal(robot.read('robots/scout.toml'), from.replace(block, ''));
  assert.equal(base.read('robots/helpers.toml'), `${helpers}\n${block}`);
  await keep(page);
  await tab(page, 'Graph').click();
  await node(page, 'OdometryChassis').click();
  await page.getByText('Odometry(1/0) on base').first().waitFor();
  const owner = async () =>
    (await base.timsctl('route', 'show')).items.find(({ address }) => address.name === 'Odometry(1/0)');
  await eventually(async () => (await owner())?.via === 'local', 'it runs at the base');
  await watched.close();
});

const views = ['graph', 'graph&at=base%3Arouter.toml', 'table', 'text', 'budgets', 'changes', 'history'];

for (const [name, rules, options] of [
  ['light', [], { colorScheme: 'light' }],
  ['dark', ['color-contrast'], { colorScheme: 'dark' }],
  ['on a phone', [], { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true }],
])
  test(`every view is accessible, ${name}`, async () => {
    const watched = await studio(options);
    const { page } = watched;
    await set(page, 'ChassisSim', 'vxMax', '700');
    for (const view of views) {
      await page.goto(`${base.address}/#/studio?view=${view}`);
      assert.deepEqual(await watched.seriousFindings(rules), [], view);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert(wide <= 0, `${view} is ${wide} pixels too wide`);
    }
    await watched.close(['Content Security Policy']);
  });

// Tab until it has the focus.
async function tabTo(page, name, keys = 80) {
  for (let i = 0; i < keys; ++i) {
    await page.keyboard.press('Tab');
    const text = await page.evaluate(() => {
      const { ariaLabel, textContent } = document.activeElement;
      return ariaLabel || textContent || '';
    });
    if (name.test(text)) return;
  }
  assert.fail(`${name} is not reached by the keyboard`);
}

test('it works by the keyboard alone', async () => {
  const watched = await studio();
  const { page } = watched;
  await page.locator('#content').focus();
  await tabTo(page, /ChassisSim/);
  await page.keyboard.press('Enter');
  await tabTo(page, /^vxMax$/);
  await page.keyboard.press('Control+a');
  await page.keyboard.type('650');
  await page.keyboard.press('Enter');
  await tab(page, 'Changes').getByText(/\d/).waitFor();
  await tabTo(page, /Review and apply/, 200);
  await page.keyboard.press('Enter');
  await page.locator('#content').focus();
  await tabTo(page, /Discard all/);
  await page.keyboard.press('Enter');
  await page.getByText('Nothing to apply').waitFor();
  await watched.close();
});

test('it works by touch, on a phone', async () => {
  const watched = await studio({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  const { page } = watched;
  await node(page, 'ChassisSim').tap();
  const box = page.getByRole('complementary', { name: 'Chosen' }).getByLabel('vxMax', { exact: true });
  await box.tap();
  await box.fill('640');
  await box.press('Enter');
  await page.getByRole('button', { name: 'Review and apply' }).tap();
  await page.getByText(/vxMax .* -> 640/).waitFor();
  await page.getByRole('button', { name: 'Discard all' }).tap();
  await page.getByText('Nothing to apply').waitFor();
  await watched.close();
});
