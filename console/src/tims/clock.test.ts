import assert from 'node:assert/strict';
import { test } from 'node:test';
import { clockOf } from './clock';

test('a worker that began later than its page has the time of the page', () => {
  const page = { timeOrigin: 1_000_000, now: () => 3500 };
  const worker = { timeOrigin: 1_002_400, now: () => 1100 };
  assert.equal(clockOf(page.timeOrigin, worker)(), page.now());
  assert.equal(clockOf(page.timeOrigin, page)(), page.now());
});
