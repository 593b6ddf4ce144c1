import assert from 'node:assert/strict';
import { test } from 'node:test';
import { structOf } from '../codec/catalogue';
import { columnsOf } from './columns';
import { KeptRings } from './kept_rings';
import { numberAt, numberFields } from './number_fields';
import { Ring } from './ring';

test('the numbers of a message, also those of its structs', () => {
  const names = numberFields(structOf('PositionData').fields).map(({ name }) => name);
  assert(names.includes('pos.x') && names.includes('var.rho'));
  assert(!names.includes('recordingTime'));
});

test('values are in SI units', () => {
  const field = numberFields(structOf('PositionData').fields).find(({ name }) => name === 'pos.x')!;
  assert.equal(numberAt({ pos: { x: 1500 } }, field), 1.5);
  assert.equal(numberAt({ pos: { x: null } }, field), undefined);
  assert.equal(numberAt({}, field), undefined);
});

test('a ring keeps the newest', () => {
  const ring = new Ring(3);
  assert.equal(ring.newest, undefined);
  for (let i = 1; i <= 5; ++i) ring.add(i, 10 * i);
  const seen: number[] = [];
  ring.each((_, value) => seen.push(value));
  assert.deepEqual(seen, [30, 40, 50]);
  assert.equal(ring.newest, 50);
});

function ringOf(...samples: [number, number][]): Ring {
  const ring = new Ring(10);
  for (const [time, value] of samples) ring.add(time, value);
  return ring;
}

test('curves share their times; a line goes on where another curve has a sample', () => {
  const { times, columns } = columnsOf([ringOf([1, 10], [2, 20]), ringOf([1.5, 7])], 0, 2);
  assert.deepEqual(times, [1, 1.5, 2]);
  assert.deepEqual(columns, [
    [10, undefined, 20],
    [undefined, 7, undefined],
  ]);
});

test('a line ends where its curve was silent, and at the window', () => {
  const { times, columns } = columnsOf([ringOf([1, 10], [3, 20], [9, 30], [11, 40])], 2, 2);
  assert.deepEqual(times, [3, 6, 9, 11]);
  assert.deepEqual(columns, [[20, null, 30, 40]]);
});

test('samples stay with their curve, and the curves that were used longest ago give way', () => {
  const rings = new KeptRings<{ name: string }>(10, 2);
  rings.of({ name: 'a' }).add(1, 10);
  rings.of({ name: 'b' });
  assert.equal(rings.of({ name: 'a' }).newest, 10);
  rings.of({ name: 'c' });
  assert.deepEqual(
    ['a', 'b', 'c'].map((name) => rings.curve(name)?.name),
    ['a', undefined, 'c'],
  );
  assert.equal(rings.of({ name: 'a' }).newest, 10);
});
