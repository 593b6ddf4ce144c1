import assert from 'node:assert/strict';
import { test } from 'node:test';
import { degrees, fixed, metres } from './quantities';

test('what is rounded to zero has no sign', () => {
  assert.equal(metres(-4), '0.00 m');
  assert.equal(metres(-6), '-0.01 m');
  assert.equal(degrees(-0.0001), '0.0°');
  assert.equal(fixed(1.005, 1), '1.0');
});
