// A fleet of `timsctl sim` is configured in the Studio as an installed one. Needs root: its hosts are network
// namespaces, and so the browser runs in that of the base.
import assert from 'node:assert/strict';
import { execFile, execFileSync } from 'node:child_process';
import { chmodSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { browserProgram, eventually, Host, launch, programs, Watched } from './fixture.mjs';

const robots = fileURLToPath(new URL('../../deploy/robots', import.meta.url));
const name = `console${process.pid % 100000}`;
const fleet = `name = "${name}"

[[robot]]
hosts = ["main", "arm"]
link = "cable"

[host.main]
robots = ["${robots}/sim.toml"]

[host.arm]
robots = ["${robots}/recorder.toml"]
`;
// The browser says that it takes this header of https only, or of this machine's own address.
const ignored = ['Cross-Origin-Opener-Policy'];
const base = { address: 'http://127.0.0.1:8080' };

let sim;
let browser;

const skip = canMakeNamespaces() ? false : 'network namespaces need root';

function canMakeNamespaces() {
  try {
    execFileSync('ip', ['netns', 'add', name], { stdio: 'ignore' });
    execFileSync('ip', ['netns', 'del', name], { stdio: 'ignore' });
    return true;
  } catch {
    return false;
  }
}

before(async () => {
  if (skip) return;
  sim = new Host();
  const file = join(sim.folder, 'fleet.toml');
  writeFileSync(file, fleet);
  const up = sim.run('timsctl', ['sim', 'up', file]);
  await eventually(() => {
    if (up.exitCode !== null) throw new Error(up.output);
    return up.output.includes('is up');
  }, 'the fleet is up');
  const there = join(sim.folder, 'chromium');
  writeFileSync(there, `#!/bin/sh\nexec nsenter --net=/run/netns/tims-${name}-base ${browserProgram} "$@"\n`);
  chmodSync(there, 0o755);
  browser = await launch([], there);
});

afterEach(Watched.closeAll);

after(async () => {
  await browser?.close();
  await sim?.end();
});

const graph = (page) => page.getByRole('region', { name: 'Hosts and components' });
const node = (page, title) => graph(page).getByRole('button', { name: new RegExp(title) });
const tab = (page, title) => page.getByRole('tab', { name: new RegExp(`^${title}`) });
const chosen = (page) => page.getByRole('complementary', { name: 'Chosen' });
const fileAt = (host, file) => readFileSync(`/run/tims-sim/${name}/${host}/etc/${file}`, 'utf8');

// timsctl at a host of the fleet.
function on(host, ...args) {
  const timsctl = join(programs, 'timsctl');
  return new Promise((resolve, reject) => {
    execFile(timsctl, ['sim', 'exec', '--fleet', name, host, timsctl, '--json', ...args], (error, stdout, stderr) => {
      if (stdout === '') reject(error ?? new Error(stderr));
      else resolve(JSON.parse(stdout));
    });
  });
}

async function studio() {
  const watched = await Watched.open(browser, base, '#/studio');
  await node(watched.page, 'Scan2d').waitFor();
  await node(watched.page, 'DatalogRec').waitFor();
  await watched.page.getByText('No problems').waitFor();
  return watched;
}

async function set(page, component, key, value) {
  await tab(page, 'Graph').click();
  if ((await node(page, component).getAttribute('aria-pressed')) !== 'true') await node(page, component).click();
  const box = chosen(page).getByLabel(key, { exact: true });
  await box.fill(value);
  await box.press('Enter');
}

async function apply(page, why) {
  await tab(page, 'Changes').click();
  await page.getByLabel('Your name').fill('ada');
  await page.getByLabel('Why', { exact: true }).fill(why);
  await page.getByRole('button', { name: /^Apply/ }).click();
  await page.getByText(`“${why}” of ada works on`).waitFor();
}

test('a parameter is changed, checked and kept', { skip }, async () => {
  const watched = await studio();
  const { page } = watched;
  await set(page, 'Scan2d', 'maxRange', '-5');
  await page.getByRole('button', { name: /^1 error/ }).waitFor();
  await set(page, 'Scan2d', 'maxRange', '7000');
  await page.getByText('No problems').waitFor();
  await tab(page, 'Changes').click();
  await page.getByText(/Scan2dSim maxRange 10000 -> 7000 mm/).waitFor();
  await apply(page, 'see less far');
  await eventually(
    async () => (await on('base', 'component', 'param', 'get', 'Scan2d(1/0)', 'maxRange')).items[0].value === 7000,
    'it runs with the new value',
  );
  await page.getByRole('button', { name: 'Keep the change' }).click();
  await page.getByText('The change is kept on').waitFor();
  assert.match(fileAt('robot1-main', 'robots/sim.toml'), /maxRange = 7000/);
  assert.match(readFileSync(`${robots}/sim.toml`, 'utf8'), /maxRange = 10000/, 'the file it came from stays');
  await watched.close(ignored);
});

test('a component moves to the other host of its robot, and back when it is not kept', { skip }, async () => {
  const watched = await studio();
  const { page } = watched;
  await tab(page, 'Graph').click();
  await node(page, 'Position').click();
  await page.getByText('Move to …').click();
  await page
    .getByRole('button', { name: /^robot1-arm/ })
    .last()
    .click();
  await page.getByText('No problems').waitFor();
  await apply(page, 'the arm has time');
  assert.match(fileAt('robot1-arm', 'robots/recorder.toml'), /program = "Position"/);
  assert.doesNotMatch(fileAt('robot1-main', 'robots/sim.toml'), /program = "Position"/);
  const hasPosition = async (host) => JSON.stringify(await on(host, 'robot')).includes('Position');
  await eventually(() => hasPosition('robot1-arm'), 'it runs on the arm');
  await page.getByRole('button', { name: 'Undo it' }).click();
  await eventually(() => hasPosition('robot1-main'), 'it runs where it did');
  assert.match(fileAt('robot1-main', 'robots/sim.toml'), /program = "Position"/);
  await watched.close(ignored);
});

test('a router that has to be restarted comes back, as by its service', { skip }, async () => {
  const watched = await studio();
  const { page } = watched;
  const epoch = async () => (await on('robot1-arm', 'status')).epoch;
  const before = await epoch();
  await page.goto(`${base.address}/#/studio?view=text&file=robot1-arm%3Arouter.toml`);
  const text = page.getByRole('textbox', { name: /router.toml on robot1-arm/ });
  await text.fill((await text.inputValue()).replace('listen = "0.0.0.0:2000"', 'listen = "0.0.0.0:2001"'));
  await apply(page, 'another port');
  await eventually(async () => (await epoch()) !== before, 'another router runs');
  await page.getByRole('button', { name: 'Keep the change' }).click();
  await page.getByText('The change is kept on').waitFor();
  await eventually(async () => (await on('base', 'component', 'list')).items.length > 0, 'the fleet answers');
  await watched.close(ignored);
});
