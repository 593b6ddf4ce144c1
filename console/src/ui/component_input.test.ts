import assert from 'node:assert/strict';
import { test } from 'node:test';
import { suggestionsFor, suggestionsMax } from './component_input';

const robots = (count: number) => Array.from({ length: count }, (_, i) => `Chassis(${i + 1}/0)`);

test('names that contain the text, in any case, in their order', () => {
  const names = ['Ladar(1/0)', 'Chassis(1/0)', 'Ladar(2/0)'];
  assert.deepEqual(suggestionsFor(' ladar', names), ['Ladar(1/0)', 'Ladar(2/0)']);
  assert.deepEqual(suggestionsFor('(1/', names), ['Ladar(1/0)', 'Chassis(1/0)']);
  assert.deepEqual(suggestionsFor('', names), names);
  assert.deepEqual(suggestionsFor('Camera', names), []);
});

test('a hundred of them, and those behind are found by more of their name', () => {
  for (const count of [suggestionsMax - 1, suggestionsMax, suggestionsMax + 1])
    assert.equal(suggestionsFor('chassis', robots(count)).length, Math.min(count, suggestionsMax));
  assert.deepEqual(suggestionsFor('(777/', robots(1000)), ['Chassis(777/0)']);
});
