import assert from 'node:assert/strict';
import { test } from 'node:test';
import { degrees, fixed, heading, metres, numberIn, utcText } from './quantities';

test('what is rounded to zero has no sign', () => {
  assert.equal(metres(-4), '0.00 m');
  assert.equal(metres(-6), '-0.01 m');
  assert.equal(degrees(-0.0001), '0.0°');
  assert.equal(fixed(1.005, 1), '1.0');
});

test('a direction is within one turn', () => {
  assert.equal(heading(2 * Math.PI - 0.0001), '0.0°');
  assert.equal(heading(-Math.PI / 2), '270.0°');
  assert.equal(heading(5 * Math.PI), '180.0°');
});

test('a time that is none is said to be none', () => {
  assert.equal(utcText(1_764_252_181n), '2025-11-27 14:03:01');
  assert.equal(utcText(0x7fff_ffff_ffff_ffffn), 'no time');
});

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
