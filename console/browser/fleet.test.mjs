// What an operator sees of a fleet: its routers and links, and what is away.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { eventually, launch, startFleet, Watched } from './fixture.mjs';

let base;
let robots;
let browser;

before(async () => {
  [base, ...robots] = await startFleet(2);
  browser = await launch();
  await robots[0].up('sim.toml', 1);
});

after(async () => {
  await browser?.close();
  for (const host of [...(robots ?? []), base]) await host?.end();
});

afterEach(Watched.closeAll);

test('the routers are a tree, and their links are up', async () => {
  const watched = await Watched.open(browser, base, '#/network');
  const { page } = watched;
  await page.getByText('3 routers').waitFor();
  await page.getByRole('tab', { name: 'Links' }).click();
  await page.getByRole('heading', { name: /robot1 up/ }).waitFor();
  await watched.close();
});

test('who is connected to a router, what routes somebody has set there, and how long it takes to answer', async () => {
  await base.ask({ ask: 'route_add', match: 'Ladar(9/*)', via: 'robot1' });
  const watched = await Watched.open(browser, base, '#/network?tab=links');
  const { page } = watched;
  await page.getByRole('row', { name: /Ladar\(9\/\*\) robot1/ }).waitFor();
  await page.getByRole('button', { name: 'Ping' }).click();
  await page.getByText(/^5 answers in /).waitFor();
  await page.getByRole('tab', { name: 'Clients' }).click();
  await page
    .getByRole('row', { name: /browser/ })
    .first()
    .waitFor();
  await base.ask({ ask: 'route_del', match: 'Ladar(9/*)', via: 'robot1' });
  await watched.close();
});

test('a robot behind a link is seen and operated', async () => {
  const watched = await Watched.open(browser, base, '#/robot/1?tiles=Scan2d/0');
  const { page } = watched;
  await page.getByRole('button', { name: /^Scan2d\/0: off/ }).click();
  await page.getByText(/\d+ points; the nearest/).waitFor();
  await page.goto(`${base.address}/#/network?tab=trace&to=Scan2d(1/0)`);
  await page.getByRole('button', { name: 'Trace' }).click();
  await page.getByText('It was answered').waitFor();
  assert.equal(await page.getByRole('row').count(), 3, 'two routers on the route');
  await watched.close();
});

test('a link that somebody takes down says so, is explained, and comes up again', async () => {
  const watched = await Watched.open(browser, base, '#/network?tab=links');
  const { page } = watched;
  const link = page.getByRole('listitem').filter({ hasText: 'robot1' });
  await link.getByRole('button', { name: 'Take down' }).click();
  await link.getByRole('heading', { name: /down/ }).waitFor();
  await page.goto(`${base.address}/#/network?tab=explain&to=Chassis(1/0)`);
  await page.getByRole('button', { name: 'Explain' }).click();
  await page.getByText(/the link of base to robot1 is down/).waitFor();
  await page.goto(`${base.address}/#/network?tab=links`);
  await link.getByRole('button', { name: 'Bring up' }).click();
  await link.getByRole('heading', { name: /robot1 up/ }).waitFor();
  await watched.close();
});

test('why a component is in error is seen also without a log, by who comes later', async () => {
  await robots[0].timsctl('component', 'on', 'Pilot(1/0)');
  const state = async () => (await robots[0].timsctl('component', 'show', 'Pilot(1/0)')).state;
  await eventually(async () => (await state()) === 'error', 'it is in error');
  const watched = await Watched.open(browser, base);
  const { page } = watched;
  const robot = page.getByRole('listitem').filter({ has: page.getByRole('heading', { name: 'Robot 1' }) });
  await robot.getByText(/no such mailbox: Joystick\(1\/0\), ON/).waitFor();
  await page.goto(`${base.address}/#/robot/1?tiles=Pilot/0`);
  await page.getByText(/It is in error: no such mailbox: Joystick/).waitFor();
  await robots[0].timsctl('component', 'off', 'Pilot(1/0)');
  await watched.close();
});

test('a robot that is away is in trouble, and one sees why', async () => {
  const watched = await Watched.open(browser, base);
  const { page } = watched;
  await page.getByRole('link', { name: 'Robot 1' }).waitFor();
  await robots[1].killRouter();
  await page.getByText(/Its router robot2 is not reachable/).waitFor();
  await robots[1].startRouter();
  await page.getByText(/Its router robot2/).waitFor({ state: 'detached' });
  await watched.close();
});

test('the loss of a link that the console sets is measured', async () => {
  const watched = await Watched.open(browser, base, '#/simulation');
  const { page } = watched;
  const box = page.getByLabel('Loss of robot1 in %');
  await box.fill('101');
  await box.press('Enter');
  await page.getByText('Loss is 0 to 100 %').waitFor();
  await box.fill('40');
  await box.press('Enter');
  await page.getByText('in force').waitFor();
  const loss = async () =>
    (await base.timsctl('link', 'show')).items.find(({ name, via }) => [name, via].includes('robot1')).loss_out;
  await eventually(async () => (await loss()) > 0.1, 'the loss is seen');
  await page.goto(`${base.address}/#/fleet`);
  const robot = page.getByRole('listitem').filter({ has: page.getByRole('heading', { name: 'Robot 1' }) });
  await robot.getByText(/^\d+ % of what is sent to it is lost/).waitFor();
  await page.getByText(/, 1 in trouble/).waitFor();
  await robot.getByRole('link', { name: 'Its link' }).click(); // one, whatever is wrong with it
  await page.getByRole('heading', { name: /robot1 up, poor/ }).waitFor();
  await page.getByText('Faults are injected into what is sent to it: 40 % lost').waitFor();
  await page.goto(`${base.address}/#/simulation`);
  await eventually(async () => (await box.inputValue()) === '40', 'the loss in force is shown');
  await page.getByRole('button', { name: 'None' }).first().click();
  await watched.close();
});

test('links, mailboxes and events of any router', async () => {
  const watched = await Watched.open(browser, base, '#/network');
  const { page } = watched;
  await page.getByRole('link', { name: 'robot1' }).click();
  await page.getByRole('heading', { name: /base up/ }).waitFor();
  await page.getByRole('tab', { name: 'Mailboxes' }).click();
  await page.getByLabel('Filter mailboxes').fill('chassis');
  const row = page.getByRole('row').filter({ has: page.getByRole('cell', { name: 'Chassis(1/0)', exact: true }) });
  await row.getByText('local').waitFor();
  await row.getByText(/^0 of \d+$/).waitFor(); // waiting, of its slots
  await page.getByRole('tab', { name: 'Events' }).click();
  await page.getByLabel('Filter events').fill('registered scan2d(1/0):0');
  await page.getByText(/^0 of \d+$/).waitFor();
  await page.getByLabel('Filter events').fill('registered scan2d(1/0)');
  await page.getByRole('cell', { name: 'Scan2d(1/0)', exact: true }).first().waitFor();
  await page.getByLabel('Router').selectOption('');
  await page.getByRole('tab', { name: 'Links' }).click();
  await page.getByRole('heading', { name: /robot1 up/ }).waitFor();
  await page.goBack();
  await page.getByLabel('Filter events').waitFor();
  await watched.close();
});

test('times are those of the zone where one is, or UTC, on every page that shows some', async () => {
  const watched = await Watched.open(browser, base, '#/network?tab=events', { timezoneId: 'Asia/Tokyo' });
  const { page } = watched;
  const newest = async () => Number((await page.locator('td.time').first().textContent()).match(/(\d\d):\d\d:\d\d/)[1]);
  await page.locator('td.time').first().waitFor();
  const local = await newest();
  await page.getByRole('button', { name: 'UTC' }).click();
  await eventually(async () => [8, 9, 10].includes((local - (await newest()) + 24) % 24), 'nine hours less'); // a new one
  for (const path of ['messages', 'network?tab=trace']) {
    await page.goto(`${base.address}/#/${path}`);
    await page.getByRole('button', { name: 'UTC', pressed: true }).waitFor();
  }
  await watched.close();
});

test('a robot whose programs have ended is missed, also by who comes again, until it is forgotten', async () => {
  const programs = await robots[1].up('sim.toml', 2);
  const watched = await Watched.open(browser, base);
  const { page } = watched;
  await page.getByRole('link', { name: 'Robot 2' }).waitFor();
  programs.kill('SIGTERM');
  await eventually(async () => !JSON.stringify(await base.timsctl('component', 'list')).includes('(2/0)'), 'they end');
  // Later, by the clock of the page.
  const later = () => {
    const now = Date.now;
    Date.now = () => now() + 60_000;
  };
  await page.addInitScript(later);
  await page.evaluate(later);
  const gone = page.getByRole('listitem').filter({ hasText: 'Robot 2' });
  await gone.getByText(/None of its components is registered since/).waitFor();
  await page.reload();
  await gone.getByText(/None of its components/).waitFor();
  await page.getByText('2 robots, 1 in trouble').waitFor();
  await gone.getByRole('button', { name: 'Forget' }).click();
  await page.getByText('1 robot, none in trouble').waitFor();
  await watched.close();
});
