import assert from 'node:assert/strict';
import { test } from 'node:test';
import { structOf } from '../codec/catalogue';
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
  assert.deepEqual(ring.times(4), [4, 5]);
});
