// A program of the original beside the console: what its graphical interface does over TCP, at the same robot, and
// gdos-log as the third that wants the texts.
import { readFileSync } from 'node:fs';
import { connect } from 'node:net';
import { after, afterEach, before, test } from 'node:test';
import { eventually, Host, launch, Watched } from './fixture.mjs';

const system = 96; // a robot of sim.toml
const sink = 0x00010000; // GDOS(0/0)
const gui = 0x00020100; // GUI(0/1)
const types = { registerMailbox: 11, lifesign: 17, getStatus: 3, getData: 4, enabled: -4, disabled: -5, data: -6 };
const classes = { chassis: 0x11, joystick: 0x17 };
const addressOf = (classId) => ((system << 24) | (classId << 16)) >>> 0;

let host;
let browser;
let original;

// Big-endian, as Java is; it polls, and owns mailboxes like a component.
class OriginalGui {
  texts = [];
  answers = new Map(); // by sender and type: how many
  received = Buffer.alloc(0);

  static start(port) {
    return new Promise((resolve, reject) => {
      const program = new OriginalGui();
      program.socket = connect(port, '127.0.0.1', () => resolve(program));
      program.socket.on('error', reject);
      program.socket.on('data', (bytes) => program.take(bytes));
    });
  }

  send(type, dest, src, body = Buffer.alloc(0), sequence = 0) {
    const header = Buffer.alloc(16);
    header.writeInt8(type, 1);
    header.writeUInt8(sequence, 3);
    header.writeUInt32BE(dest, 4);
    header.writeUInt32BE(src, 8);
    header.writeUInt32BE(16 + body.length, 12);
    this.socket.write(Buffer.concat([header, body]));
  }

  register(address) {
    const body = Buffer.alloc(4);
    body.writeUInt32BE(address);
    this.send(types.registerMailbox, 0, 0, body);
  }

  take(bytes) {
    this.received = Buffer.concat([this.received, bytes]);
    for (;;) {
      if (this.received.length < 16) return;
      const word = (at) =>
        (this.received[0] & 1) === 1 ? this.received.readUInt32LE(at) : this.received.readUInt32BE(at);
      const length = word(12);
      if (this.received.length < length) return;
      const [type, dest, src] = [this.received.readInt8(1), word(4), word(8)];
      const body = this.received.subarray(16, length);
      this.received = this.received.subarray(length);
      if (dest === 0 && type === types.lifesign) this.send(0, 0, 0);
      else if (dest === sink) this.texts.push(body.toString('latin1').split('\0')[0]);
      else this.answers.set(`${src}:${type}`, (this.answers.get(`${src}:${type}`) ?? 0) + 1);
    }
  }

  count(src, type) {
    return this.answers.get(`${src}:${type}`) ?? 0;
  }

  end() {
    clearInterval(this.polls);
    this.socket.destroy();
  }
}

before(async () => {
  host = await Host.start();
  browser = await launch();
  host.run('gdos-log', ['--directory', `${host.folder}/log`]);
  await host.up('sim.toml', system);
  original = await OriginalGui.start(host.tcp);
  for (const address of [gui, sink]) original.register(address);
  const chassis = addressOf(classes.chassis);
  original.polls = setInterval(() => {
    original.send(types.getStatus, chassis, gui);
    original.send(types.getData, chassis, gui, Buffer.alloc(4));
  }, 200);
});

after(async () => {
  original?.end();
  await browser?.close();
  await host?.end();
});

afterEach(Watched.closeAll);

test('what the console turns on, the original program sees, and both have the texts', async () => {
  const watched = await Watched.open(browser, host, `#/robot/${system}?tiles=Chassis/0`);
  const { page } = watched;
  const chassis = addressOf(classes.chassis);
  await eventually(() => original.count(chassis, types.disabled) > 0, 'the original program sees that it is off');
  await page.getByRole('button', { name: /^Chassis\/0: off/ }).click();
  await page.getByRole('region', { name: 'Chassis/0' }).getByText('forward').waitFor();
  await eventually(() => original.count(chassis, types.enabled) > 0, 'and that it is on');
  await eventually(() => original.count(chassis, types.data) > 0, 'and its data');
  await eventually(() => original.texts.some((text) => text.includes('Module on')), 'and the text');
  await page.getByRole('link', { name: 'Messages' }).click();
  await page
    .getByRole('row', { name: new RegExp(`Chassis\\(${system}/0\\).*Module on`) })
    .first()
    .waitFor();
  const stored = () => readFileSync(`${host.folder}/log/texts.jsonl`, 'utf8');
  await eventually(() => stored().includes('Module on'), 'the log has stored it');
  await watched.close();
});

test('its stick is not taken from it', async () => {
  original.register(addressOf(classes.joystick));
  const watched = await Watched.open(browser, host, `#/drive/${system}`);
  await watched.page.getByRole('button', { name: `Drive with Pilot(${system}/0)` }).click();
  await watched.page.getByRole('alert').filter({ hasText: 'somebody else' }).waitFor();
  await watched.close();
});

test('who comes late has the texts from before', async () => {
  const watched = await Watched.open(browser, host, '#/messages');
  await watched.page
    .getByRole('row', { name: new RegExp(`Chassis\\(${system}/0\\).*Module on`) })
    .first()
    .waitFor();
  await watched.close();
});
