// A robot stands when the page that drives it is hidden, cut off or stalled; and what a page does whose router is away.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { eventually, Host, Line, launch, Watched } from './fixture.mjs';
import { Speed } from './speed.mjs';

const system = 94; // a robot of sim.toml
const chassis = `Chassis(${system}/0)`;
const pilot = `Pilot(${system}/0)`;
const lost = ['WebSocket', 'ERR_CONNECTION', 'Failed to load resource', 'ERR_EMPTY_RESPONSE'];

let host;
let line;
let browser;
let speed;

before(async () => {
  host = await Host.start();
  line = await Line.start(host.http);
  browser = await launch();
  await host.up('sim.toml', system);
  speed = new Speed(host, chassis);
});

after(async () => {
  await browser?.close();
  line?.end();
  await host?.end();
});

afterEach(Watched.closeAll);

const stateOf = async (name) => (await host.timsctl('component', 'status', name)).state;

// A page that drives, with a key that stays down.
async function driving() {
  const watched = await Watched.open(browser, line, `#/drive/${system}`);
  const { page } = watched;
  await page.getByRole('button', { name: /^(Drive|Take over) with/ }).click();
  await page.getByRole('button', { name: 'Release' }).waitFor();
  await eventually(async () => (await stateOf(pilot)) === 'on', 'the pilot is on');
  await page.keyboard.down('ArrowUp');
  await speed.drives();
  return watched;
}

test('it stands when its page is hidden', async () => {
  const watched = await driving();
  await speed.stopsBy('the page is hidden', () =>
    watched.page.evaluate(() => {
      Object.defineProperty(document, 'hidden', { value: true, configurable: true });
      document.dispatchEvent(new Event('visibilitychange'));
    }),
  );
  await watched.close();
});

test('it stands when the page is cut off from the router, which the page says, and it takes the stick anew', async () => {
  const watched = await driving();
  const { page } = watched;
  await speed.stopsBy('the line is cut', () => line.cut());
  await page.getByRole('alert').filter({ hasText: 'No connection to the router' }).waitFor();
  await page.keyboard.up('ArrowUp');
  line.mend();
  await page.getByRole('alert').filter({ hasText: 'No connection' }).waitFor({ state: 'detached' });
  await page.getByRole('button', { name: /^Drive with/ }).waitFor();
  await watched.close(lost);
});

test('it stands when the page and its worker are stalled', async () => {
  const watched = await driving();
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send('SystemInfo.getProcessInfo');
  const renderers = processInfo.filter(({ type }) => type === 'renderer').map(({ id }) => id);
  assert(renderers.length > 0);
  try {
    await speed.stopsBy('page and worker are stalled', () => {
      for (const id of renderers) process.kill(id, 'SIGSTOP');
    });
  } finally {
    for (const id of renderers) process.kill(id, 'SIGCONT');
  }
  await watched.page.keyboard.up('ArrowUp');
  await watched.close(lost);
});

test('a command is done once, or the page says that it is not, when the router dies meanwhile', async () => {
  const watched = await Watched.open(browser, host, `#/robot/${system}?tiles=Odometry/0`);
  const { page } = watched;
  const lamp = (state) => page.getByRole('button', { name: new RegExp(`^Odometry/0: ${state}`) });
  await host.timsctl('component', 'on', `Odometry(${system}/0)`);
  await lamp('on').waitFor();
  await host.killRouter();
  await page.getByRole('alert').filter({ hasText: 'No connection to the router' }).waitFor({ timeout: 2000 });
  await lamp('on')
    .click({ timeout: 5000 })
    .catch(() => {}); // its state may be unknown by now
  await host.startRouter();
  await page.getByRole('alert').filter({ hasText: 'No connection' }).waitFor({ state: 'detached' });
  // It was not kept to be done later: nobody would expect it then.
  await eventually(async () => (await stateOf(`Odometry(${system}/0)`)) === 'on', 'it is still on');
  await lamp('on').waitFor();
  await watched.close(lost);
});
