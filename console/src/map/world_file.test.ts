import assert from 'node:assert/strict';
import { test } from 'node:test';
import { readWorldFile, worldFileOf } from './world_file';

const origin = { north: 5800000, east: 3550000 };

test('the upper left corner is half a pixel beside the centre of its pixel', () => {
  const place = readWorldFile('0.5\n0\n0\n-0.5\n3550010.25\n5800099.75\n', origin);
  assert.deepEqual(place, { north: 100000, west: 10000, cell: 500 });
});

test('a world file that is written is read as the same place', () => {
  const place = { north: 100250, west: -10125, cell: 250 };
  assert.deepEqual(readWorldFile(worldFileOf(place), { north: 0, east: 0 }), place);
});

test('what cannot be shown is refused in words', () => {
  assert.throws(() => readWorldFile('1 2 3', origin), /six numbers/);
  assert.throws(() => readWorldFile('1 0 0 x 0 0', origin), /six numbers/);
  assert.throws(() => readWorldFile('1 0.1 0 -1 0 0', origin), /turned/);
  assert.throws(() => readWorldFile('1 0 0 -2 0 0', origin), /square/);
  assert.throws(() => readWorldFile('-1 0 0 1 0 0', origin), /square/);
});
