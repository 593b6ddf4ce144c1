// What an operator did in the original's graphical interface (tests/data/recordings/a-gui-drive), done in the console:
// the components get the same commands.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, afterEach, before, test } from 'node:test';
import { gunzipSync } from 'node:zlib';
import { eventually, Host, launch, Watched } from './fixture.mjs';
import { Swarm } from './swarm.mjs';

const recording = new URL('../../tests/data/recordings/a-gui-drive.jsonl.gz', import.meta.url);
const gui = 'gui click: ';
const types = { on: 1, off: 2, getNextData: 8, getParam: 9, param: -9, getContData: 6, data: -6 };
const polls = [3, 4, types.getNextData];
const joystick = 0x00170000; // the interface itself, as the console is
const pilots = [0x00180000, 0x00180100];

// The commands that each click sent: { click: [{ type, dest, body }] }; bodies are words, big-endian there.
function recorded() {
  const clicks = new Map();
  let commands = [];
  for (const line of gunzipSync(readFileSync(recording)).toString().split('\n')) {
    if (line === '') continue;
    const { ev, text, peer, dir, hex } = JSON.parse(line);
    if (ev === 'mark') {
      commands = [];
      if (text.startsWith(gui)) clicks.set(text.slice(gui.length), commands);
    }
    if (peer !== 'gui' || dir !== 'c2r') continue;
    const message = Buffer.from(hex, 'hex');
    const [type, dest] = [message.readInt8(1), message.readUInt32BE(4)];
    if (type <= 0 || polls.includes(type) || dest === 0 || dest === joystick) continue;
    const words = message.subarray(16);
    commands.push({ type, dest, body: Array.from({ length: words.length / 4 }, (_, i) => words.readUInt32BE(4 * i)) });
  }
  return clicks;
}

// PARAM of a pilot that listens to a joystick: joystickSys and joystickInst.
function joystickParameters() {
  const size = 172;
  const body = Buffer.alloc(4 + 2 * size);
  body.writeInt32LE(2, 0);
  body.write('joystickSys', 4);
  body.write('joystickInst', 4 + size);
  return body;
}

const clicks = recorded();
let host;
let browser;
let swarm;
let watched;

before(async () => {
  host = await Host.start();
  browser = await launch();
  swarm = await Swarm.start(host.tcp);
  const none = Buffer.alloc(4);
  for (const address of [0x00110000, 0x00120000, 0x00130000, 0x00190000, ...pilots])
    swarm.add(address, undefined, undefined, { [types.getParam]: [types.param, none] });
  swarm.components.get(pilots[0]).answers[types.getParam] = [types.param, joystickParameters()];
  watched = await Watched.open(browser, host, '#/robot/0');
});

after(async () => {
  await watched?.close();
  swarm?.end();
  await browser?.close();
  await host?.end();
});

// What the components got since then, in the form of the recording.
function journal() {
  const { journal } = swarm;
  swarm.journal = [];
  return journal
    .filter(({ type, dest }) => type > 0 && ![...polls, types.getParam].includes(type) && dest !== joystick)
    .map(({ type, dest, body }) => {
      const bytes = Buffer.from(body, 'hex');
      return { type, dest, body: Array.from({ length: bytes.length / 4 }, (_, i) => bytes.readUInt32LE(4 * i)) };
    });
}

// The same commands in the same order; the console may have sent others between them.
function assertSame(click, sent) {
  const expected = clicks.get(click);
  assert(expected?.length > 0, `${click} is in the recording`);
  let at = 0;
  for (const each of sent) if (JSON.stringify(each) === JSON.stringify(expected[at])) ++at;
  assert.equal(at, expected.length, `${click}: ${JSON.stringify(expected)}, sent ${JSON.stringify(sent)}`);
}

const lamp = (name, state) => watched.page.getByRole('button', { name: new RegExp(`^${name}: ${state}`) });

for (const [click, name] of [
  ['chassis on', 'Chassis/0'],
  ['odometry on', 'Odometry/0'],
  ['scan2d on', 'Scan2d/0'],
  ['position on', 'Position/0'],
])
  test(click, async () => {
    journal();
    await lamp(name, 'off').click();
    await lamp(name, 'on').waitFor();
    assertSame(click, journal());
  });

test('PilotJoystick becomes active pilot and is turned on, and is driven', async () => {
  await watched.page.goto(`${host.address}/#/drive/0`);
  journal();
  await watched.page.getByRole('button', { name: 'Drive with Pilot(0/0)' }).click();
  await watched.page.getByRole('button', { name: 'Release' }).waitFor();
  assertSame('PilotJoystick becomes active pilot and is turned on', journal());
  // The pilot listens to the stick, as it did to the interface's: forward is a positive x.
  const mailbox = pilots[0] + 1;
  const period = Buffer.alloc(8);
  period.writeUInt32LE(mailbox, 4);
  swarm.own(mailbox);
  swarm.send({ type: types.getContData, dest: joystick, src: mailbox, sequence: 1 }, period);
  await watched.page.keyboard.down('ArrowUp');
  const forward = () =>
    swarm.journal.find(({ type, dest, body }) => {
      const bytes = Buffer.from(body, 'hex');
      return type === types.data && dest === mailbox && bytes.length === 32 && bytes.readInt32LE(4) > 0;
    });
  await eventually(forward, 'the stick is forward');
  await watched.page.keyboard.up('ArrowUp');
});

test('PilotWallFollowing becomes active pilot and is turned on', async () => {
  journal();
  await watched.page.getByRole('button', { name: 'Start Pilot(0/1)' }).click();
  await watched.page.getByText('Pilot(0/1) drives.').waitFor();
  assertSame('PilotWallFollowing becomes active pilot and is turned on', journal());
});

test('all off', async () => {
  await watched.page.goto(`${host.address}/#/robot/0`);
  await lamp('Pilot/1', 'on').waitFor();
  const on = [...swarm.components].filter(([, { on }]) => on).map(([address]) => address);
  journal();
  await watched.page.getByRole('button', { name: 'All off' }).click();
  const result = watched.page.getByText(/^(All are off|Not all: .*)$/);
  await result.waitFor();
  assert.equal(await result.textContent(), 'All are off');
  const off = (list) => list.filter(({ type }) => type === types.off).map(({ dest }) => dest);
  const sent = off(journal());
  // What is off already gets nothing; the pilots go off before the chassis, too.
  const expected = off(clicks.get('all off')).filter((address) => on.includes(address));
  assert.deepEqual([...sent].sort(), [...expected].sort());
  assert(sent.indexOf(pilots[1]) < sent.indexOf(0x00110000));
});

afterEach(() => assert.deepEqual(watched.troubles, []));
