// The session against a router that is played here, on a virtual clock.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { addressOf, originalWidths } from './address';
import { decodeHeader, encodeMessage, type Header, headerSize, types, wordAt, wordBody } from './header';
import { Session, type SessionEvent } from './session';

const ladar = addressOf({ system: 3, classId: 0x14 }, originalWidths);
const joystick = addressOf({ system: 3, classId: 0x17 }, originalWidths);
const status = { name: 'vm', address: { raw: '0x03000100' }, epoch: 'abc', version: '1', widths: [8, 8, 8, 8] };

type Sent = { header: Header; body: Uint8Array };

class FakeSocket {
  isOpen = false;
  opened = 0;
  unsent = 0;
  sent: Sent[] = [];
  open() {
    this.isOpen = true;
    ++this.opened;
  }
  close() {
    this.isOpen = false;
  }
  send(message: Uint8Array<ArrayBuffer>) {
    const header = decodeHeader(message);
    assert(header !== undefined);
    this.sent.push({ header, body: message.subarray(headerSize) });
  }
  take(type: number): Sent {
    const at = this.sent.findIndex(({ header }) => header.type === type);
    assert(at >= 0, `nothing of type ${type} was sent`);
    return this.sent.splice(at, 1)[0]!;
  }
  has(type: number): boolean {
    return this.sent.some(({ header }) => header.type === type);
  }
}

class Fixture {
  now = 1000;
  control = new FakeSocket();
  data = new FakeSocket();
  events: SessionEvent[] = [];
  pings: number[] = []; // that are not answered
  session = new Session(
    { control: this.control, data: this.data },
    (event) => this.events.push(event),
    () => 0.5,
    () => 77,
  );

  connect() {
    this.session.tick(this.now);
    for (const name of ['control', 'data'] as const) this.introduce(name);
    return this;
  }

  introduce(name: 'control' | 'data') {
    this.session.socket(name).opened(this.now);
    this.receive(name, { type: types.adminReply }, new TextEncoder().encode(JSON.stringify(status)));
    this.receive(name, { type: types.ok });
  }

  receive(name: 'control' | 'data', header: Partial<Header>, body?: Uint8Array) {
    this.session.socket(name).received(encodeMessage(header, body), this.now);
  }

  pass(time: number, step = 25) {
    for (const end = this.now + time; this.now < end; ) {
      this.now += step;
      this.session.tick(this.now);
    }
  }

  last<Is extends SessionEvent['is']>(is: Is) {
    return this.events.filter((event) => event.is === is).at(-1) as Extract<SessionEvent, { is: Is }> | undefined;
  }
}

test('it is connected when both sockets have their mailboxes', () => {
  const fixture = new Fixture();
  fixture.session.tick(fixture.now);
  fixture.introduce('control');
  assert.equal(fixture.last('connected'), undefined);
  fixture.introduce('data');
  assert.equal(fixture.last('connected')?.router.name, 'vm');
});

test('a mailbox that belongs to somebody else is drawn again', () => {
  const fixture = new Fixture();
  fixture.session.tick(fixture.now);
  fixture.session.socket('control').opened(fixture.now);
  fixture.receive('control', { type: types.adminReply }, new TextEncoder().encode(JSON.stringify(status)));
  fixture.control.take(13);
  fixture.receive('control', { type: types.error });
  assert(fixture.control.has(13));
});

test('an answer finds its call by sender and number', async () => {
  const fixture = new Fixture().connect();
  const call = fixture.session.call(
    { dest: ladar, type: types.getStatus, body: new Uint8Array(), timeout: 500 },
    fixture.now,
  );
  const { header } = fixture.control.take(types.getStatus);
  fixture.receive('control', { type: types.error, src: ladar, dest: header.src, sequence: header.sequence + 1 });
  fixture.receive('control', { type: types.enabled, src: ladar, dest: header.src, sequence: header.sequence });
  assert.equal((await call).type, types.enabled);
});

test('a call without an answer fails in time, and one more than 255 at once', async () => {
  const fixture = new Fixture().connect();
  const ask = () => fixture.session.call({ dest: ladar, type: 3, body: new Uint8Array(), timeout: 500 }, fixture.now);
  const calls = Array.from({ length: 255 }, ask);
  await assert.rejects(ask(), /255 requests/);
  fixture.pass(525);
  const results = await Promise.allSettled(calls);
  assert(results.every(({ status: is }) => is === 'rejected'));
  const late = ask();
  fixture.receive('control', { type: 0, src: ladar, sequence: fixture.control.sent.at(-1)!.header.sequence });
  await late;
});

test('a question to the own router has no sender', () => {
  const fixture = new Fixture().connect();
  void fixture.session.call({ dest: 0, type: types.adminRequest, body: new Uint8Array(), timeout: 500 }, fixture.now);
  const sent = fixture.control.sent.at(-1)!;
  assert.equal(sent.header.src, 0);
  assert.notEqual(sent.header.sequence, 0);
});

test('a stream is asked for with the shortest period, and ended when nobody wants it', () => {
  const fixture = new Fixture().connect();
  fixture.session.subscribe(ladar, 1, 200, false, fixture.now);
  fixture.session.subscribe(ladar, 2, 100, false, fixture.now);
  fixture.pass(25);
  const { body, header } = fixture.control.take(types.getContData);
  assert.equal(wordAt(body, 0, header.flags), 100);
  assert.equal(wordAt(body, 4, header.flags), fixture.session.socket('data').mailbox);
  fixture.receive('control', { type: types.contData, src: ladar }, wordBody(100));
  assert.equal(fixture.last('stream')?.state, 'flowing');
  fixture.session.unsubscribe(ladar, 1, fixture.now);
  fixture.session.unsubscribe(ladar, 2, fixture.now);
  fixture.pass(900);
  assert(!fixture.control.has(types.stopContData), 'it lingers');
  fixture.pass(200);
  assert(fixture.control.has(types.stopContData));
});

test('samples at the former period do not stand in for the answer to a new one', () => {
  const fixture = new Fixture().connect();
  const asked = () => wordAt(fixture.control.take(types.getContData).body, 0, 2);
  fixture.session.subscribe(ladar, 1, 66, false, fixture.now);
  fixture.pass(25);
  assert.equal(asked(), 66);
  fixture.receive('control', { type: types.contData, src: ladar }, wordBody(66));
  fixture.session.subscribe(ladar, 1, 13, false, fixture.now);
  fixture.receive('data', { type: types.data, src: ladar });
  fixture.pass(25);
  assert.equal(asked(), 13, 'it is asked for although a sample has come meanwhile');
  fixture.receive('data', { type: types.data, src: ladar });
  fixture.pass(1025);
  assert.equal(asked(), 13, 'no answer has come');
  fixture.receive('control', { type: types.contData, src: ladar }, wordBody(13));
  fixture.receive('data', { type: types.data, src: ladar });
  fixture.pass(1025);
  assert(!fixture.control.has(types.getContData));
});

test('pictures are asked for at a lower priority than scans', () => {
  const fixture = new Fixture().connect();
  const camera = 0x03150000;
  for (const component of [ladar, camera]) fixture.session.subscribe(component, 1, 66, false, fixture.now);
  fixture.pass(25);
  const scans = fixture.control.take(types.getContData).header;
  const pictures = fixture.control.take(types.getContData).header;
  assert.equal(scans.dest, ladar);
  assert.equal(pictures.dest, camera);
  assert(scans.priority > pictures.priority, `${scans.priority} ${pictures.priority}`);
});

test('what comes is counted in bytes a second', () => {
  const fixture = new Fixture().connect();
  fixture.pass(1000);
  fixture.receive('data', { type: types.data, src: ladar }, new Uint8Array(984));
  fixture.pass(1000);
  assert.equal(fixture.last('rate')?.bytesPerSecond, 1000);
});

test('the data mailbox keeps the newest samples only, the other one all messages', () => {
  const fixture = new Fixture().connect();
  const options = (name: 'control' | 'data') => wordAt(fixture[name].take(13).body, 4, 2);
  assert.equal(options('data'), 1);
  assert.equal(options('control'), undefined);
});

const kept = JSON.stringify({
  address: { raw: '0x03140000' },
  type: -6,
  age_s: 9,
  little_endian: true,
  body: '0a000000',
});

// The question of a session to its router, and the router's answer to it.
function answerOf(fixture: Fixture, ask: string, text: string) {
  const question = fixture.control.sent.find(
    ({ header, body }) => header.type === types.adminRequest && JSON.parse(new TextDecoder().decode(body)).ask === ask,
  );
  assert(question !== undefined, `${ask} was not asked`);
  const { sequence } = question.header;
  fixture.control.sent = fixture.control.sent.filter((sent) => sent !== question);
  fixture.receive('control', { type: types.adminReply, sequence }, new TextEncoder().encode(text));
  return JSON.parse(new TextDecoder().decode(question.body));
}

const settled = () => new Promise((resolve) => setImmediate(resolve));

test('a view that opens gets the value that the router has kept, with its age', async () => {
  const fixture = new Fixture().connect();
  fixture.control.sent = [];
  fixture.session.subscribe(ladar, 1, 200, false, fixture.now);
  assert.equal(answerOf(fixture, 'newest', kept).of, '0x03140000');
  await settled();
  const sample = fixture.last('sample')?.sample;
  assert.equal(sample?.at, fixture.now - 9000);
  assert.equal(wordAt(sample!.message, headerSize, 2), 10);
  fixture.session.subscribe(ladar, 2, 100, false, fixture.now);
  assert(!fixture.control.has(types.adminRequest), 'a second view does not ask');
});

test('a sample that has come is newer than what the router has kept', async () => {
  const fixture = new Fixture().connect();
  fixture.session.subscribe(ladar, 1, 200, false, fixture.now);
  fixture.receive('data', { type: types.data, src: ladar }, wordBody(11));
  answerOf(fixture, 'newest', kept);
  await settled();
  assert.equal(fixture.events.filter(({ is }) => is === 'sample').length, 1);
});

test('drops at the router are reported', async () => {
  const fixture = new Fixture().connect();
  fixture.session.subscribe(ladar, 1, 13, false, fixture.now);
  const answer = (samples: number, dropped: number) =>
    JSON.stringify({ items: [{ from: { raw: '0x03140000' }, samples, dropped }] });
  fixture.pass(25);
  assert.equal(Number(answerOf(fixture, 'streams', answer(10, 0)).to), fixture.session.socket('data').mailbox);
  await settled();
  fixture.pass(2000);
  answerOf(fixture, 'streams', answer(160, 126));
  await settled();
  assert.deepEqual(fixture.last('drops')?.rate, { samples: 75, dropped: 63 });
});

test('a silent stream, and one whose component goes off, is asked for again', () => {
  const fixture = new Fixture().connect();
  fixture.session.subscribe(ladar, 1, 100, false, fixture.now);
  fixture.pass(25);
  fixture.control.take(types.getContData);
  fixture.receive('control', { type: types.contData, src: ladar }, wordBody(100));
  fixture.pass(1500);
  assert(!fixture.control.has(types.getContData), 'four periods may pass');
  fixture.pass(500);
  fixture.control.take(types.getContData);
  fixture.receive('data', { type: types.error, src: ladar });
  assert.equal(fixture.last('stream')?.state, 'refused');
  fixture.pass(1050);
  assert(fixture.control.has(types.getContData));
});

test('the page gets the newest sample when it has taken the one before', () => {
  const fixture = new Fixture().connect();
  fixture.session.subscribe(ladar, 1, 0, false, fixture.now);
  const send = (number: number) => fixture.receive('data', { type: types.data, src: ladar }, wordBody(number));
  for (let number = 1; number <= 5; ++number) send(number);
  const samples = () => fixture.events.flatMap((event) => (event.is === 'sample' ? [event.sample] : []));
  const numbers = () => samples().map(({ message }) => wordAt(message, headerSize, 3));
  assert.deepEqual(numbers(), [1]);
  fixture.session.taken(ladar);
  assert.deepEqual(numbers(), [1, 5]);
  assert.equal(samples().at(-1)?.skipped, 3);
});

test('a stream of texts loses none', () => {
  const fixture = new Fixture().connect();
  fixture.session.subscribe(ladar, 1, 0, true, fixture.now);
  fixture.pass(25);
  const { body } = fixture.control.take(types.getContData);
  assert.equal(wordAt(body, 4, 2), fixture.session.socket('control').mailbox, 'not where only the newest is kept');
  for (let number = 1; number <= 5; ++number)
    fixture.receive('control', { type: types.data, src: ladar }, wordBody(number));
  assert.equal(fixture.events.filter(({ is }) => is === 'sample').length, 5);
});

test('a lost connection fails the calls, opens again with growing pauses, and asks for the streams anew', async () => {
  const fixture = new Fixture().connect();
  fixture.session.subscribe(ladar, 1, 100, false, fixture.now);
  fixture.pass(25);
  fixture.control.take(types.getContData);
  const call = fixture.session.call({ dest: ladar, type: 3, body: new Uint8Array(), timeout: 5000 }, fixture.now);
  fixture.session.socket('data').closed('gone', fixture.now);
  await assert.rejects(call, /lost: gone/);
  assert.equal(fixture.last('lost')?.why, 'gone');
  const { opened } = fixture.control;
  fixture.pass(250);
  assert.equal(fixture.control.opened, opened + 1);
  for (let i = 0; i < 20; ++i) {
    fixture.session.socket('control').closed('refused', fixture.now);
    fixture.session.socket('data').closed('refused', fixture.now);
    fixture.pass(5025);
  }
  fixture.introduce('control');
  fixture.introduce('data');
  fixture.pass(25);
  assert(fixture.control.has(types.getContData));
});

test('new connections are made on request, and the calls of the old ones fail', async () => {
  const fixture = new Fixture().connect();
  const call = fixture.session.call({ dest: ladar, type: types.getStatus, body: new Uint8Array(), timeout: 500 }, 1000);
  fixture.session.reconnect(fixture.now);
  await assert.rejects(call, /connection/);
  assert.equal(fixture.last('lost')?.why, 'connecting anew');
  assert.ok(!fixture.control.isOpen && !fixture.data.isOpen);
  fixture.pass(250);
  assert.deepEqual([fixture.control.opened, fixture.data.opened], [2, 2]);
  fixture.introduce('control');
  fixture.introduce('data');
  assert.equal(fixture.events.filter(({ is }) => is === 'connected').length, 2);
});

test('a router that no longer answers is given up after some seconds', () => {
  const fixture = new Fixture().connect();
  fixture.pass(2025);
  fixture.receive('control', { type: types.adminReply });
  fixture.receive('data', { type: types.adminReply });
  assert(fixture.last('roundTrip') !== undefined);
  fixture.pass(5900);
  assert.equal(fixture.last('lost'), undefined);
  fixture.pass(200);
  assert.match(fixture.last('lost')?.why ?? '', /does not answer/);
});

test('a message of a wrong length ends the connection', () => {
  const fixture = new Fixture().connect();
  fixture.session.socket('control').received(new Uint8Array(15), fixture.now);
  assert.match(fixture.last('lost')?.why ?? '', /wrong length/);
});

// --- the stick

async function withStick(): Promise<Fixture> {
  const fixture = new Fixture().connect();
  const taken = fixture.session.takeStick(joystick, fixture.now);
  const { header } = fixture.control.sent.at(-1)!;
  fixture.receive('control', { type: types.ok, sequence: header.sequence });
  await taken;
  return fixture;
}

const pilotMailbox = 0x03180001;

function listen(fixture: Fixture, period: number) {
  fixture.receive(
    'control',
    { type: types.getContData, dest: joystick, src: pilotMailbox, sequence: 9 },
    wordBody(period, pilotMailbox),
  );
}

const position = ({ body }: Sent) => [wordAt(body, 4, 2)! | 0, wordAt(body, 8, 2)! | 0];

test('a stick that somebody else has is refused', async () => {
  const fixture = new Fixture().connect();
  const taken = fixture.session.takeStick(joystick, fixture.now);
  fixture.receive('control', { type: types.error, sequence: fixture.control.sent.at(-1)!.header.sequence });
  await assert.rejects(taken, /somebody else/);
});

test('a pilot that listens gets the stick every period', async () => {
  const fixture = await withStick();
  listen(fixture, 120);
  const granted = fixture.control.take(types.contData);
  assert.equal(wordAt(granted.body, 0, 2), 100);
  fixture.control.sent = [];
  fixture.session.moveStick({ x: 50, y: -20, z: 0, buttons: 0 }, fixture.now);
  const sent = fixture.control.take(types.data);
  assert.deepEqual(position(sent), [50, -20]);
  assert.equal(sent.header.dest, pilotMailbox);
  assert.equal(sent.header.sequence, 9);
});

test('a stick that nobody moves any longer springs back after 250 ms, and zero is sent three times', async () => {
  const fixture = await withStick();
  listen(fixture, 100);
  fixture.session.moveStick({ x: 50, y: 0, z: 0, buttons: 0 }, fixture.now);
  fixture.pass(225);
  assert(
    fixture.control.sent.filter(({ header }) => header.type === types.data).every((sent) => position(sent)[0] === 50),
  );
  fixture.control.sent = [];
  fixture.pass(100);
  const zeros = fixture.control.sent.filter(({ header }) => header.type === types.data);
  assert(zeros.length >= 3);
  assert(zeros.every((sent) => position(sent)[0] === 0));
});

const held = { x: 50, y: 0, z: 0, buttons: 0 };

// Somebody holds the stick; the router answers to signs of life after `delay` ms, or never.
function hold(fixture: Fixture, time: number, delay = Number.POSITIVE_INFINITY) {
  const positions: number[] = [];
  for (const end = fixture.now + time; fixture.now < end; ) {
    fixture.pass(25);
    fixture.session.moveStick(held, fixture.now);
    for (const sent of fixture.control.sent.splice(0)) {
      if (sent.header.type === types.data) positions.push(position(sent)[0]!);
      if (sent.header.type === types.adminRequest && sent.header.sequence === 0) fixture.pings.push(fixture.now);
    }
    while (fixture.now >= (fixture.pings[0] ?? Number.POSITIVE_INFINITY) + delay) {
      fixture.pings.shift();
      fixture.receive('control', { type: types.adminReply });
    }
  }
  return positions;
}

test('while the line takes nothing the stick is not sent, then its newest position only', async () => {
  const fixture = await withStick();
  listen(fixture, 50);
  hold(fixture, 200, 25);
  fixture.control.unsent = 48;
  assert.deepEqual(hold(fixture, 200, 25), []);
  fixture.session.moveStick({ ...held, x: 10 }, fixture.now);
  fixture.session.moveStick({ ...held, x: 20 }, fixture.now);
  fixture.control.unsent = 0;
  fixture.pass(25);
  assert.deepEqual(position(fixture.control.take(types.data)), [20, 0]);
  assert(!fixture.control.has(types.data));
});

test('the stick rests when the line has taken nothing for 0.3 s, until it is free', async () => {
  const fixture = await withStick();
  listen(fixture, 50);
  hold(fixture, 200, 25);
  fixture.control.unsent = 48;
  hold(fixture, 300, 25);
  assert.equal(fixture.last('slowLine'), undefined);
  hold(fixture, 50, 25);
  assert.equal(fixture.last('slowLine')?.slow, true);
  fixture.session.releaseStick();
  assert.equal(fixture.last('slowLine')?.slow, false, 'nobody drives');
});

test('what was held while the line took nothing for 0.3 s arrives as zero', async () => {
  const fixture = await withStick();
  listen(fixture, 50);
  hold(fixture, 200, 25);
  fixture.control.unsent = 48;
  hold(fixture, 400, 25);
  fixture.control.unsent = 0;
  fixture.pass(25);
  assert.deepEqual(position(fixture.control.take(types.data)), [0, 0]);
  assert.equal(fixture.last('slowLine')?.slow, false);
  assert.deepEqual(hold(fixture, 200, 25).at(-1), 50, 'it is still held');
});

test('the stick rests when the router needs more than 0.3 s to answer, until it is faster', async () => {
  const fixture = await withStick();
  listen(fixture, 50);
  assert(
    hold(fixture, 1000, 200)
      .slice(1)
      .every((x) => x === 50),
  );
  assert.equal(fixture.last('slowLine'), undefined);
  const before = hold(fixture, 425);
  assert.deepEqual(before.slice(-3), [0, 0, 0], 'it is known 0.4 s after the last answer');
  assert.equal(fixture.last('slowLine')?.slow, true);
  assert(
    hold(fixture, 2000, 400).every((x) => x === 0),
    'it answers, but late',
  );
  hold(fixture, 500, 100);
  assert.equal(fixture.last('slowLine')?.slow, false);
  assert(hold(fixture, 200, 100).every((x) => x === 50));
});

test('signs of life are asked for ten times a second while somebody drives, and told once a second', async () => {
  const fixture = await withStick();
  hold(fixture, 2000, 25);
  fixture.receive('control', { type: types.adminReply });
  const told = () => fixture.events.filter(({ is }) => is === 'roundTrip').length;
  assert(told() >= 1 && told() <= 3, `${told()}`);
  const asked = () => fixture.control.sent.filter(({ header }) => header.type === types.adminRequest).length;
  fixture.pass(100);
  fixture.receive('control', { type: types.adminReply });
  fixture.pass(100);
  assert.equal(asked(), 2);
  fixture.receive('control', { type: types.adminReply });
  fixture.session.releaseStick();
  fixture.control.sent = [];
  fixture.pass(1800);
  assert.equal(asked(), 0);
});

test('the stick answers as a component does', async () => {
  const fixture = await withStick();
  const ask = (type: number) => fixture.receive('control', { type, dest: joystick, src: pilotMailbox, sequence: 4 });
  ask(types.getStatus);
  assert.equal(fixture.control.take(types.enabled).header.sequence, 4);
  ask(types.getData);
  assert.deepEqual(position(fixture.control.take(types.data)), [0, 0]);
  ask(99);
  fixture.control.take(types.error);
  listen(fixture, 100);
  ask(types.notAvailable);
});

test('the stick goes with the connection', async () => {
  const fixture = await withStick();
  fixture.session.socket('control').closed('gone', fixture.now);
  assert.equal(fixture.last('stick')?.address, undefined);
});
