// Who may only look: every control that would command is disabled, with the reason as its title. All other controls of
// all views are used: none of them commands something, or is refused.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, afterEach, before, test } from 'node:test';
import { eventually, Host, launch, Watched } from './fixture.mjs';
import { addressOf, Swarm } from './swarm.mjs';

const schema = JSON.parse(readFileSync(new URL('../src/codec/schema.json', import.meta.url), 'utf8'));
const system = 7;
const period = 100; // ms
const reason = /^Your login may only look: this needs the right to (drive|configure)\.$/;
const controls = 'button, input, select, textarea';

let host;
let browser;
let swarm;

before(async () => {
  host = await Host.start();
  browser = await launch();
  swarm = await Swarm.start(host.tcp);
  const made = (struct) => Buffer.from(schema.structs.find(({ name }) => name === struct).made, 'hex');
  for (const { name, id, messages } of schema.classes) {
    const struct = messages.find(({ name: message }) => message === 'DATA')?.body;
    if (struct === undefined || id < 0x10 || name === 'World') continue;
    swarm.add(addressOf(system, id, 0), () => made(struct), period);
  }
});

after(async () => {
  swarm?.end();
  await browser?.close();
  await host?.end();
});

afterEach(Watched.closeAll);

const component = (name) =>
  swarm.components.get(addressOf(system, schema.classes.find((each) => each.name === name).id, 0));

// A page of somebody who may only look; the router of this story asks nobody.
async function opened(path) {
  const watched = await Watched.open(browser, host, '');
  await watched.page.route('**/login', (route) => route.fulfill({ json: { user: 'anna', right: 'look' } }));
  await watched.page.goto(`${host.address}/${path}`);
  await watched.page.reload();
  return watched;
}

// Of those that are disabled for want of a right, the names.
async function disabledIn(box) {
  const found = await box
    .locator(controls)
    .evaluateAll((elements) =>
      elements
        .filter((element) => element.disabled)
        .map((element) => [
          element.ariaLabel ?? element.labels?.[0]?.textContent ?? element.textContent,
          element.title,
        ]),
    );
  return found.filter(([, title]) => reason.test(title)).map(([name]) => name.trim());
}

// One after the other, as the page is drawn anew after each.
const useAll = (box) =>
  box.evaluate(async (element, selector) => {
    const change = (control) => control.dispatchEvent(new Event('change', { bubbles: true }));
    for (let i = 0; ; ++i) {
      const control = element.querySelectorAll(selector)[i];
      if (control === undefined) return;
      if (control.disabled || control.type === 'file' || control.closest('details:not([open])') !== null) continue;
      if (control instanceof HTMLSelectElement) {
        control.selectedIndex = (control.selectedIndex + 1) % control.options.length;
        change(control);
      } else if (control.matches('button, [type=checkbox], [type=radio]')) control.click();
      else {
        control.value = '1';
        control.dispatchEvent(new Event('input', { bubbles: true }));
        change(control);
      }
      await new Promise(requestAnimationFrame);
    }
  }, controls);

const askedOfAll = schema.every_class.filter(({ name }) => /^(GET|STOP)_/.test(name)).map(({ type }) => type);

function onlyReads({ type, dest }) {
  if (type <= 0 || askedOfAll.includes(type)) return true;
  const { messages } = schema.classes.find(({ id }) => id === ((dest >>> 16) & 0xff));
  return /^GET_|_TO_/.test(messages.find((message) => message.type === type).name);
}

const expected = {
  Chassis: [`Pilot(${system}/0)`, 'nobody', 'Let it drive'],
  Odometry: ['Set to zero'],
  Position: ['It is here', `It is where Gps(${system}/0) is`],
  Camera: ['Set'],
  Pilot: ['Hold', 'Go on', 'Set destination'],
  Datalog: ['Stop recording', 'Folder'],
  ObjRecog: ['Set estimate'],
  Vehicle: ['Set hold'],
  Io: ['Set'],
  ServoDrive: ['Home hold', '−100', '+100', 'Stop', 'Go there', 'Turn at this velocity hold'],
  Planner: ['Send'],
  FeatureMap: ['Load', 'Save'],
  Mcl: ['Load'],
  PtzDrive: ['Go there', 'Turn at these per second hold', 'Home hold', 'Stop'],
};

test('views: what would command is disabled, all else commands nothing', async () => {
  const watched = await opened('#/fleet');
  const { page } = watched;
  const names = schema.classes.map(({ name }) => name).filter((name) => component(name) !== undefined);
  await page.goto(`${host.address}/#/robot/${system}?tiles=${names.map((name) => `${name}/0`)}`);
  for (const name of names) {
    const tile = page.getByRole('region', { name: `${name}/0`, exact: true });
    await tile.scrollIntoViewIfNeeded(); // until then it asks for no data
    const body = tile.locator('.tile-body');
    await eventually(async () => {
      for (const summary of await body.locator('details:not([open]) > summary').all()) await summary.click();
      assert.deepEqual(await disabledIn(body), expected[name] ?? []);
      return true;
    }, `${name}: what is disabled`);
    await useAll(body);
    await tile.getByRole('button', { name: 'Commands', exact: true }).click();
    const send = body.getByRole('button', { name: 'Send' });
    if ((await body.getByText('no commands of its own').count()) === 0) await send.waitFor();
    await useAll(body);
    assert.equal(await page.getByText('needs the right to').count(), 0, `${name}: something is refused`);
    assert.deepEqual(
      swarm.journal.filter((message) => !onlyReads(message)),
      [],
      name,
    );
    swarm.journal.length = 0;
  }
  await watched.close();
});

test('a command that only reads can be sent', async () => {
  const watched = await opened(`#/robot/${system}?tiles=Chassis/0`);
  const tile = watched.page.getByRole('region', { name: 'Chassis/0', exact: true });
  await tile.getByRole('button', { name: 'Commands', exact: true }).click();
  const command = tile.getByLabel('Command');
  const send = tile.getByRole('button', { name: 'Send' });
  await command.selectOption({ label: 'MOVE' });
  assert(await send.isDisabled());
  await command.selectOption({ label: 'GET_PARAMETER' });
  assert(await send.isEnabled());
  await watched.close();
});

test('pages: what would command is disabled', async () => {
  const watched = await opened('#/fleet');
  const { page } = watched;
  const bar = page.locator('header.bar');
  await bar.getByRole('button', { name: `Stop robot ${system}` }).waitFor();
  assert.deepEqual(await disabledIn(bar), [`Stop robot ${system}`]);
  for (const [path, wait, names] of [
    ['#/fleet', 'All off', ['Stop', 'All off']],
    [`#/robot/${system}`, 'All off', ['All off', 'Pilot/0: ']],
    [`#/map?robots=${system}`, 'Send robot here', ['Send robot here', 'Action']],
    ['#/recorder', 'Stop recording', ['Stop recording']],
    ['#/messages', 'Clear', ['Set']],
  ]) {
    await page.goto(`${host.address}/${path}`);
    await page.locator('main').getByRole('button', { name: wait, exact: true }).first().waitFor();
    const found = await disabledIn(page.locator('main'));
    for (const name of names)
      assert(
        found.some((each) => each.startsWith(name)),
        `${path}: ${name} of ${found}`,
      );
  }
  await watched.close();
});
