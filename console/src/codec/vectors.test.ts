// The same bytes as the C++ codec: all vectors that tims-schema makes, and those of original programs.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, readFileSync } from 'node:fs';
import { test } from 'node:test';
import { addressText, fieldsOf, originalWidths } from '../tims/address';
import { decodeHeader, flags, headerSize } from '../tims/header';
import { className, findMessage, structOf } from './catalogue';
import { hexOf, toJson } from './json';
import type { Structs } from './messages';
import { bytesOfHex, CodecError, type Fields, type Struct } from './struct';

const program = process.env.TIMS_SCHEMA ?? '../build/release/bin/tims-schema';
const printed = (...options: string[]) => spawnSync(program, options, { encoding: 'utf8', maxBuffer: 2 ** 26 }).stdout;
const skip = existsSync(program) ? false : `${program} is not built: ninja -C build/release tims-schema`;

const jsonOf = (struct: Struct, value: Fields) =>
  toJson(struct, value, (address) => addressText(address, originalWidths, className));

function result(struct: Struct, body: Uint8Array, little: boolean): string {
  try {
    return jsonOf(struct, struct.decode(body, little));
  } catch (error) {
    if (!(error instanceof CodecError)) throw error;
    return `!${error.message}`;
  }
}

interface Vector {
  struct: Struct;
  little: boolean;
  body: Uint8Array;
  expected: string;
}

let made: Vector[] | undefined;

function vectors(): Vector[] {
  made ??= printed('--vectors')
    .trimEnd()
    .split('\n')
    .map((line) => {
      const [name, order, hex] = line.split(' ', 3) as [keyof Structs, string, string];
      const expected = line.slice(name.length + order.length + hex.length + 3);
      return { struct: structOf(name), little: order === 'little', body: bytesOfHex(hex === '-' ? '' : hex), expected };
    });
  return made;
}

test('bodies of every struct mean the same as in C++', { skip }, () => {
  for (const { struct, little, body, expected } of vectors())
    assert.equal(result(struct, body, little), expected, `${struct.name} ${hexOf(body)}`);
});

test('bodies of every struct are encoded as they were', { skip }, () => {
  for (const { struct, little, body, expected } of vectors()) {
    if (expected.startsWith('!')) continue;
    const again = struct.encode(struct.decode(body, little), little);
    assert.equal(result(struct, again, little), expected);
  }
});

test('of every body, all truncations but the valid ones are refused', { skip }, () => {
  const all = vectors();
  const valid = new Set(
    all.filter((v) => !v.expected.startsWith('!')).map((v) => key(v.struct, v.little, hexOf(v.body))),
  );
  for (const { struct, little, body, expected } of all) {
    if (expected.startsWith('!') || body.length > 500) continue;
    const hex = hexOf(body);
    for (let size = 0; size < body.length; ++size) {
      const cut = body.subarray(0, size);
      const refused = result(struct, cut, little).startsWith('!');
      assert.equal(
        refused,
        !valid.has(key(struct, little, hex.slice(0, 2 * size))),
        `${struct.name}, ${size} of ${body.length} bytes`,
      );
    }
  }
});

const key = (struct: Struct, little: boolean, hex: string) => `${struct.name} ${little} ${hex}`;

// name origin flags type priority seq_nr dest src length header body
test('messages of original programs', () => {
  let bodies = 0;
  for (const line of readFileSync('../tests/data/vectors.txt', 'utf8').split('\n')) {
    const [name = '', , flagsHex, type, priority, sequence, dest, src, length, head = '', body = '-'] =
      line.split(/ +/);
    if (line === '' || name === '#' || name === 'V90') continue; // V90 is corrupt
    const message = bytesOfHex(head + (body === '-' ? '' : body));
    const header = decodeHeader(message);
    const stated = [flagsHex, dest, src].map((hex) => Number.parseInt(hex!, 16));
    const decimal = [type, priority, sequence, length].map(Number);
    assert.ok(header, name);
    assert.deepEqual([header.flags, header.dest, header.src], stated, name);
    assert.deepEqual([header.type, header.priority, header.sequence, header.length], decimal, name);
    bodies += Number(meansTheSameAgain(name, header, message.subarray(headerSize)));
  }
  assert.ok(bodies > 40, `${bodies}`);
});

function meansTheSameAgain(
  name: string,
  header: { flags: number; type: number; dest: number; src: number },
  body: Uint8Array,
): boolean {
  const classOf = (address: number) => fieldsOf(address, originalWidths).classId;
  const message =
    (header.type > 0 ? findMessage(classOf(header.dest), header.type) : undefined) ??
    findMessage(classOf(header.src), header.type);
  const isMalformed = name === 'V73';
  if (message?.body === undefined || body.length === 0 || isMalformed || header.dest === 0) return false;
  const little = (header.flags & flags.bodyLittleEndian) !== 0;
  const first = result(message.body, body, little);
  assert.ok(!first.startsWith('!'), `${name}: ${first}`);
  const again = message.body.encode(message.body.decode(body, little), little);
  assert.equal(result(message.body, again, little), first, name);
  return true;
}

test('the description and the types are those of the program', { skip }, () => {
  const there = (file: string) => readFileSync(`src/codec/${file}`, 'utf8');
  assert.ok(there('schema.json') === printed(), `renew it: ${program} > console/src/codec/schema.json`);
  assert.ok(
    there('messages.ts') === printed('--types'),
    `renew it: ${program} --types > console/src/codec/messages.ts`,
  );
});
