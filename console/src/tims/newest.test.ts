import assert from 'node:assert/strict';
import { test } from 'node:test';
import { decodeHeader, flags, headerSize, types } from './header';
import { keptSample } from './newest';

const answer = (fields: object) =>
  JSON.stringify({
    address: { name: 'Position(3/0)', raw: '0x03130000' },
    type: types.data,
    age_s: 12.5,
    little_endian: true,
    body: '00ff10',
    ...fields,
  });

test('a kept value is the message that passed, with its age', () => {
  const kept = keptSample(answer({}));
  assert(kept !== undefined);
  assert.equal(kept.age, 12500);
  const header = decodeHeader(kept.message);
  assert.equal(header?.src, 0x03130000);
  assert.equal(header?.type, types.data);
  assert.deepEqual([...kept.message.subarray(headerSize)], [0, 255, 16]);
});

test('its body stays in the byte order of its sender', () => {
  const bits = (fields: object) => decodeHeader(keptSample(answer(fields))!.message)!.flags;
  assert.notEqual(bits({}) & flags.bodyLittleEndian, 0);
  assert.equal(bits({ little_endian: false }) & flags.bodyLittleEndian, 0);
});

test('what is no kept value is none', () => {
  const wrong = [
    '',
    'null',
    JSON.stringify({ error: { code: 'none_kept' } }),
    answer({ body: '0' }),
    answer({ body: 'xy' }),
    answer({ body: 7 }),
    answer({ age_s: null }),
    answer({ age_s: -1 }),
    answer({ type: types.enabled }),
  ];
  for (const text of wrong) assert.equal(keptSample(text), undefined, text);
  assert.equal(keptSample(answer({ body: '' }))?.message.length, headerSize);
});
