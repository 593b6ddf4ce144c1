// Components that are played by one TCP client, as many as wanted: they answer GET_STATUS, are turned on and off, send
// data at the period of whoever asks, and keep what they are commanded.
import { connect } from 'node:net';

const headerSize = 16;
const journalMax = 1000;
const types = { ok: 0, error: -1, notAvailable: -3, enabled: -4, disabled: -5, data: -6, contData: -7 };
const commands = { on: 1, off: 2, getStatus: 3, getData: 4, getContData: 6, stopContData: 7 };
const register = 11;
const lifesign = 17;
const littleEndian = 3;
const stream = 0x10;
const keepNewest = 1; // wire/tcp_protocol.h

export const addressOf = (system, classId, instance) => ((system << 24) | (classId << 16) | (instance << 8)) >>> 0;

export class Swarm {
  components = new Map(); // address: { on, data(): Buffer, listeners: Map(mailbox, { period, dueAt }), commands, answers }
  received = Buffer.alloc(0);
  sent = 0;
  journal = []; // { type, dest, body } of all messages to its mailboxes

  static start(port) {
    return new Promise((resolve, reject) => {
      const swarm = new Swarm();
      swarm.socket = connect(port, '127.0.0.1', () => resolve(swarm));
      swarm.socket.setNoDelay(true);
      swarm.socket.on('error', reject);
      swarm.socket.on('data', (bytes) => swarm.take(bytes));
      swarm.timer = setInterval(() => swarm.publish(performance.now()), 2);
    });
  }

  // `answers`: what it answers to a command, { type: [type, body] }; OK to others.
  add(address, data, period, answers) {
    this.components.set(address, {
      on: data !== undefined,
      data,
      period,
      listeners: new Map(),
      commands: [],
      answers,
    });
    this.own(address);
  }

  // A mailbox that answers nothing. Only the newest samples may wait for it, and its own are marked as such.
  own(address) {
    const body = Buffer.alloc(8);
    body.writeUInt32LE(address);
    body.writeUInt32LE(keepNewest, 4);
    this.send({ type: register, dest: 0, src: 0 }, body);
  }

  end() {
    clearInterval(this.timer);
    this.socket.destroy();
  }

  send({ type, dest, src, flags = 0, priority = 0, sequence = 0 }, body = Buffer.alloc(0)) {
    const header = Buffer.alloc(headerSize);
    header.writeUInt8(flags | littleEndian, 0);
    header.writeInt8(type, 1);
    header.writeUInt8(priority, 2);
    header.writeUInt8(sequence, 3);
    header.writeUInt32LE(dest, 4);
    header.writeUInt32LE(src, 8);
    header.writeUInt32LE(headerSize + body.length, 12);
    this.socket.write(header);
    if (body.length > 0) this.socket.write(body);
  }

  take(bytes) {
    this.received = this.received.length === 0 ? bytes : Buffer.concat([this.received, bytes]);
    for (;;) {
      if (this.received.length < headerSize) return;
      const little = (this.received[0] & 1) !== 0;
      const word = (message, at) => (little ? message.readUInt32LE(at) : message.readUInt32BE(at));
      const length = word(this.received, 12);
      if (this.received.length < length) return;
      const message = this.received.subarray(0, length);
      this.received = this.received.subarray(length);
      const [, , priority, sequence] = message;
      const header = { type: message.readInt8(1), priority, sequence, dest: word(message, 4), src: word(message, 8) };
      this.answer(header, message);
    }
  }

  answer({ type, priority, sequence, dest, src }, message) {
    if (dest === 0) {
      if (type === lifesign) this.send({ type: types.ok, dest: 0, src: 0, priority, sequence });
      return;
    }
    this.journal.push({ type, dest, body: message.subarray(headerSize).toString('hex') });
    if (this.journal.length > journalMax) this.journal.shift();
    const component = this.components.get(dest);
    if (component === undefined) return;
    const reply = (answer, body) => this.send({ type: answer, dest: src, src: dest, priority, sequence }, body);
    const word = (at) => message.readUInt32LE(headerSize + at);
    switch (type) {
      case commands.on:
      case commands.off:
        component.on = type === commands.on;
        return reply(types.ok);
      case commands.getStatus:
        return reply(component.on ? types.enabled : types.disabled);
      case commands.getData:
        return component.data === undefined ? reply(types.error) : reply(types.data, component.data());
      case commands.getContData: {
        if (component.data === undefined) return reply(types.error);
        const period = Math.max(component.period, word(0));
        component.listeners.set(word(4), { period, dueAt: performance.now(), priority, sequence });
        const body = Buffer.alloc(4);
        body.writeUInt32LE(period);
        return reply(types.contData, body);
      }
      case commands.stopContData:
        component.listeners.delete(word(0));
        return reply(types.ok);
      case types.notAvailable:
        component.listeners.delete(src);
        return;
      default:
        if (type <= 0) return;
        if (component.answers === undefined) return reply(types.error);
        component.commands.push({ at: Date.now(), type, priority, body: message.subarray(headerSize).toString('hex') });
        return reply(...(component.answers[type] ?? [types.ok]));
    }
  }

  // A page that has lost its connection takes leave of nobody: routers report that to TCP clients for commands only.
  forgetWhoIsGone() {
    for (const [address, { listeners }] of this.components)
      for (const dest of listeners.keys()) this.send({ type: commands.getStatus, dest, src: address });
  }

  get listeners() {
    return [...this.components.values()].reduce((sum, { listeners }) => sum + listeners.size, 0);
  }

  // What is due at a time goes out at once.
  publish(now) {
    this.socket.cork();
    for (const [address, component] of this.components)
      for (const [mailbox, listener] of component.listeners) {
        if (now < listener.dueAt) continue;
        listener.dueAt = Math.max(listener.dueAt + listener.period, now - listener.period);
        ++this.sent;
        this.send(
          {
            type: types.data,
            dest: mailbox,
            src: address,
            flags: stream,
            priority: listener.priority,
            sequence: listener.sequence,
          },
          component.data(),
        );
      }
    this.socket.uncork();
  }
}

const turns = 64;

// A scan of this many points that turns from sample to sample. They are made beforehand: a browser that is measured beside
// needs the processor.
export function ladarData(points) {
  const bodies = Array.from({ length: turns }, (_, i) => ladarBody(points, (2 * Math.PI * i) / turns));
  let next = 0;
  return () => {
    const body = Buffer.from(bodies[next++ % turns]);
    body.writeUInt32LE(Math.round(performance.now()) >>> 0, 0);
    return body;
  };
}

function ladarBody(points, turn) {
  const body = Buffer.alloc(24 + 16 * points);
  body.writeUInt32LE(13, 4);
  body.writeInt32LE(8000, 8);
  body.writeFloatLE(-Math.PI / 2, 12);
  body.writeFloatLE(Math.PI / 2, 16);
  body.writeInt32LE(points, 20);
  for (let i = 0; i < points; ++i) {
    const angle = -Math.PI / 2 + (Math.PI * i) / (points - 1);
    body.writeFloatLE(angle, 24 + 16 * i);
    body.writeInt32LE(Math.round(4000 + 1500 * Math.sin(5 * angle + turn)), 28 + 16 * i);
  }
  return body;
}

// A picture of 24 bits a pixel.
export function cameraData(width, height) {
  const rgb24 = 11;
  const body = Buffer.alloc(16 + 3 * width * height, 90);
  body.writeUInt16LE(width, 4);
  body.writeUInt16LE(height, 6);
  body.writeUInt16LE(24, 8);
  body.writeUInt16LE(rgb24, 10);
  let row = 0;
  return () => {
    row = (row + 7) % height;
    body.writeUInt32LE(Math.round(performance.now()) >>> 0, 0);
    body.fill(200, 16 + 3 * width * row, 16 + 3 * width * (row + 1));
    return Buffer.from(body);
  };
}
