import assert from 'node:assert/strict';
import { test } from 'node:test';
import { bytesOfHex, hexDump } from './hex';

test('bytes are shown in rows, with their letters', () => {
  const bytes = Uint8Array.from({ length: 10 }, (_, i) => 0x40 + i);
  bytes[1] = 0x80;
  assert.equal(hexDump(bytes), '0000  40 80 42 43 44 45 46 47  @.BCDEFG\n0008  48 49                    HI');
  assert.equal(hexDump(new Uint8Array()), '');
});

test('bytes are read with or without blanks, and nothing else is', () => {
  assert.deepEqual([...bytesOfHex('01 a0FF')], [1, 0xa0, 0xff]);
  assert.deepEqual([...bytesOfHex(' ')], []);
  for (const bad of ['1', '0x01', 'zz', '01 2']) assert.throws(() => bytesOfHex(bad), /two hex digits/, bad);
});
