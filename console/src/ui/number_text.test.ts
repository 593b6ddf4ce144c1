import assert from 'node:assert/strict';
import { test } from 'node:test';
import { numberIn } from './number_text';

test('a number has a point or a comma', () => {
  assert.equal(numberIn('1.5'), 1.5);
  assert.equal(numberIn('1,5'), 1.5);
  assert.equal(numberIn(' -7 '), -7);
  assert.equal(numberIn('0x07180000'), 0x07180000);
});

test('nothing, words, two commas, and what is not finite are none', () => {
  for (const text of ['', ' ', 'fast', '1,000,000', '1.5.2', 'NaN', 'Infinity', '1e999', '5 m'])
    assert.equal(numberIn(text), undefined, text);
});
