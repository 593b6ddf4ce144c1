import assert from 'node:assert/strict';
import { test } from 'node:test';
import { RobotsSeen } from './robots_seen';

const hour = 3600_000;

function storage() {
  const texts = new Map<string, string>();
  return {
    getItem: (key: string) => texts.get(key) ?? null,
    setItem: (key: string, text: string) => void texts.set(key, text),
  };
}

test('who comes again knows the robots of this router, not those of another', () => {
  const store = storage();
  new RobotsSeen(store).note('base', [1, 2], 10 * hour);
  const seen = new RobotsSeen(store);
  seen.note('base', [2], 11 * hour);
  assert.deepEqual([...seen.times.value].sort(), [
    [1, 10 * hour],
    [2, 11 * hour],
  ]);
  seen.note('other', [], 11 * hour);
  assert.equal(seen.times.value.size, 0);
});

test('a robot is forgotten by hand, and after a day', () => {
  const seen = new RobotsSeen(storage());
  seen.note('base', [1, 2, 3], 0.5 * hour);
  seen.forget(2);
  assert.deepEqual([...seen.times.value.keys()], [1, 3]);
  seen.note('base', [3], 24.4 * hour);
  assert.deepEqual([...seen.times.value.keys()].sort(), [1, 3]);
  seen.note('base', [3], 24.6 * hour);
  assert.deepEqual([...seen.times.value.keys()], [3]);
});

test('what is stored is checked', () => {
  const store = storage();
  store.setItem('rack.seen.base', '[[1, 3600000], "x", [2], [null, 5]]');
  const seen = new RobotsSeen(store);
  seen.note('base', [], 2 * hour);
  assert.deepEqual([...seen.times.value.keys()], [1]);
  store.setItem('rack.seen.torn', '[[1');
  seen.note('torn', [], 2 * hour);
  assert.equal(seen.times.value.size, 0);
});
