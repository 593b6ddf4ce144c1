// A program of somebody who has installed rack-codec: node package_user.mjs VECTORS.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import * as codec from 'rack-codec';

const textOfAddress = (address) => codec.addressText(address, codec.originalWidths, codec.className);

function result(struct, body, little) {
  try {
    return codec.toJson(struct, struct.decode(body, little), textOfAddress);
  } catch (error) {
    assert.ok(error instanceof codec.CodecError, error);
    return `!${error.message}`;
  }
}

const lines = readFileSync(process.argv[2], 'utf8').trimEnd().split('\n');
assert.ok(lines.length > 1000);
for (const line of lines) {
  const [name, order, hex] = line.split(' ', 3);
  const expected = line.slice(name.length + order.length + hex.length + 3);
  const body = codec.bytesOfHex(hex === '-' ? '' : hex);
  assert.equal(result(codec.structOf(name), body, order === 'little'), expected, line.slice(0, 200));
}

const { type, body } = codec.encodeNamed('Chassis.MOVE', { vx: 200 });
const message = codec.encodeWithHeader({ dest: 0x00110000, type }, body);
const header = codec.decodeHeader(message);
assert.deepEqual([header.type, header.dest, header.length], [21, 0x00110000, 28]);
assert.equal(codec.decodeStruct('ChassisMoveData', message.subarray(codec.headerSize), header.flags).vx, 200);
console.log(`${lines.length} vectors`);
