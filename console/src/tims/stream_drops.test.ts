import assert from 'node:assert/strict';
import { test } from 'node:test';
import { StreamDrops } from './stream_drops';

const counts = (...items: [number, number, number][]) =>
  JSON.stringify({
    items: items.map(([raw, samples, dropped]) => ({ from: { raw: `0x${raw.toString(16)}` }, samples, dropped })),
  });

test('rates come from two answers, and end with the drops', () => {
  const drops = new StreamDrops();
  assert.deepEqual(drops.update(counts([1, 1000, 100], [2, 10, 0]), 1000), []);
  assert.deepEqual(drops.update(counts([1, 1150, 226], [2, 30, 0]), 3000), [
    { component: 1, rate: { samples: 75, dropped: 63 } },
  ]);
  assert.deepEqual(drops.update(counts([1, 1300, 226], [2, 50, 0]), 5000), [{ component: 1, rate: undefined }]);
  assert.deepEqual(drops.update(counts([1, 1450, 226], [2, 70, 0]), 7000), []);
});

test('after a new connection the counts begin anew', () => {
  const drops = new StreamDrops();
  drops.update(counts([1, 100, 50]), 0);
  drops.restart();
  assert.deepEqual(drops.update(counts([1, 300, 200]), 1000), []);
});

test('what is no list changes nothing', () => {
  const drops = new StreamDrops();
  for (const answer of ['', '{}', '{"error":{}}', 'null']) assert.deepEqual(drops.update(answer, 0), []);
});
