// A tree of many routers that answer at once, played between a browser and its router in place of those behind it: what
// the page itself needs for them is measured. Questions for lists of routers are answered here, everything else passes.
import { connect, createServer } from 'node:net';

const headerSize = 16;
const adminRequest = 64;
const adminReply = -64;
const binary = 0x82; // a whole frame of bytes, of WebSocket

export class RouterTree {
  static start(size, port) {
    const tree = new RouterTree();
    tree.size = size;
    tree.server = createServer((near) => tree.pass(near, connect(port, '127.0.0.1')));
    return new Promise((resolve) => tree.server.listen(0, '127.0.0.1', () => resolve(tree)));
  }

  get address() {
    return `http://127.0.0.1:${this.server.address().port}`;
  }

  end() {
    this.server.close();
  }

  pass(near, far) {
    const up = new Frames(far, (frame, payload) => {
      const answer = frame[0] === binary ? this.answer(payload) : undefined;
      if (answer === undefined) far.write(frame);
      else near.write(frameOf(answer));
    });
    const down = new Frames(near, (frame) => near.write(frame));
    near.on('data', (bytes) => up.take(bytes));
    far.on('data', (bytes) => down.take(bytes));
    for (const [from, to] of [
      [near, far],
      [far, near],
    ]) {
      from.on('error', () => {});
      from.on('close', () => to.destroy());
    }
  }

  answer(message) {
    if (message.length < headerSize || message.readInt8(1) !== adminRequest) return undefined;
    const dest = (message[0] & 1) === 1 ? message.readUInt32LE(4) : message.readUInt32BE(4);
    const question = JSON.parse(message.subarray(headerSize));
    if (question.ask !== 'routers') return undefined;
    const body = Buffer.from(JSON.stringify({ schema: 'tims/router_list/1', items: this.listOf(dest) }));
    const header = Buffer.from(message.subarray(0, headerSize));
    header.writeInt8(adminReply, 1);
    // It goes back to where it came from.
    message.copy(header, 4, 8, 12);
    message.copy(header, 8, 4, 8);
    const length = headerSize + body.length;
    if ((message[0] & 1) === 1) header.writeUInt32LE(length, 12);
    else header.writeUInt32BE(length, 12);
    return Buffer.concat([header, body]);
  }

  listOf(dest) {
    if (dest === 0) return [item(0, 'self'), ...Array.from({ length: this.size }, (_, i) => item(i + 1, 'sub'))];
    const number = ((dest >>> 16) & 0xffff) % 65_536;
    return [item(number, 'self'), item(0, 'super')];
  }
}

const addressOf = (number) => `0x${((number << 16) | 16).toString(16).padStart(8, '0')}`;

const item = (number, kind) => ({
  name: number === 0 ? 'base' : `robot${number}`,
  role: number === 0 ? 'top' : 'system',
  system: number,
  id: 1,
  address: { name: `Tims(${number}/1)`, raw: addressOf(number) },
  kind,
  state: 'up',
  via: 'link',
  since_s: 10,
  rtt_s: 0.002,
  clock: { offset_s: 0.001, uncertainty_s: 0.001 },
});

// The bytes of one direction: HTTP passes, what follows a change to WebSocket is cut into whole frames.
class Frames {
  bytes = Buffer.alloc(0);
  isSocket = false;

  constructor(to, take) {
    this.to = to;
    this.takeWhole = take;
  }

  take(bytes) {
    this.bytes = Buffer.concat([this.bytes, bytes]);
    if (!this.isSocket) this.takeHead();
    while (this.isSocket && this.takeFrame());
  }

  takeHead() {
    const end = this.bytes.indexOf('\r\n\r\n');
    if (end < 0 || !/^upgrade: websocket/im.test(this.bytes.subarray(0, end).toString('latin1'))) {
      this.to.write(this.bytes);
      this.bytes = Buffer.alloc(0);
      return;
    }
    this.to.write(this.bytes.subarray(0, end + 4));
    this.bytes = this.bytes.subarray(end + 4);
    this.isSocket = true;
  }

  // False: it is not whole yet.
  takeFrame() {
    const { bytes } = this;
    if (bytes.length < 2) return false;
    const short = bytes[1] & 0x7f;
    const lengthSize = short === 127 ? 8 : short === 126 ? 2 : 0;
    const maskSize = (bytes[1] & 0x80) !== 0 ? 4 : 0;
    const begin = 2 + lengthSize + maskSize;
    if (bytes.length < begin) return false;
    const length = short === 127 ? Number(bytes.readBigUInt64BE(2)) : short === 126 ? bytes.readUInt16BE(2) : short;
    if (bytes.length < begin + length) return false;
    const payload = Buffer.from(bytes.subarray(begin, begin + length));
    const mask = bytes.subarray(begin - maskSize, begin);
    for (let i = 0; maskSize > 0 && i < length; ++i) payload[i] ^= mask[i & 3];
    this.bytes = bytes.subarray(begin + length);
    this.takeWhole(bytes.subarray(0, begin + length), payload);
    return true;
  }
}

// The length in as few bytes as it needs: others are refused.
function frameOf(payload) {
  const size = payload.length;
  if (size < 126) return Buffer.concat([Buffer.from([binary, size]), payload]);
  const head = Buffer.alloc(size < 65_536 ? 4 : 10);
  head.writeUInt8(binary, 0);
  head.writeUInt8(size < 65_536 ? 126 : 127, 1);
  if (size < 65_536) head.writeUInt16BE(size, 2);
  else head.writeBigUInt64BE(BigInt(size), 2);
  return Buffer.concat([head, payload]);
}
