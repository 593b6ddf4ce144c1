import assert from 'node:assert/strict';
import { test } from 'node:test';
import { gdosText, levelOf } from './gdos';

const bytes = (...parts: (string | number[])[]) =>
  Uint8Array.from(parts.flatMap((part) => (typeof part === 'string' ? [...new TextEncoder().encode(part)] : part)));
const i32 = (value: number) => [...new Uint8Array(Int32Array.of(value).buffer)];
const f64 = (value: number) => [...new Uint8Array(Float64Array.of(value).buffer)];
const little = 2;
const text = (body: Uint8Array) => gdosText(body, little, (address) => `<${address.toString(16)}>`);

test('levels by their types', () => {
  assert.equal(levelOf(-125), 'error');
  assert.equal(levelOf(0), undefined);
});

test('a format without arguments, and one without a NUL as Java programs send it', () => {
  assert.equal(text(bytes('Module on', [0])), 'Module on');
  assert.equal(text(bytes('Module on')), 'Module on');
  assert.equal(text(bytes('')), '');
});

test('every conversion', () => {
  assert.equal(text(bytes('%d %i %u', [0], i32(-1), i32(2), i32(-3))), '-1 2 -3');
  assert.equal(text(bytes('%x %b', [0], i32(255), i32(5))), 'ff 101');
  assert.equal(text(bytes('%n', [0], i32(0x03140000))), '<3140000>');
  assert.equal(text(bytes('%f %a', [0], f64(1.5), f64(Math.PI))), '1.500 180.00');
  assert.equal(text(bytes('%L', [0], i32(7), i32(0))), '7');
  assert.equal(text(bytes('%5.2d%%', [0], i32(9))), '9%');
});

test('pointers of 8 and of 4 bytes', () => {
  assert.equal(text(bytes('%p', [0], i32(16), i32(0))), '0x10');
  assert.equal(text(bytes('%p', [0], i32(16))), '0x10');
});

test('a text before other arguments, as it should be and as C programs of the original send it', () => {
  assert.equal(text(bytes('%s: %d', [0], 'ab', [0], i32(7))), 'ab: 7');
  assert.equal(text(bytes('%s: %d', [0], 'ab', i32(7), [0])), 'ab: 7');
});

test('big endian', () => {
  assert.equal(
    gdosText(bytes('%d', [0, 0, 0, 0, 9]), 0, () => ''),
    '9',
  );
});

test('broken arguments leave what could be read', () => {
  assert.equal(text(bytes('speed %d of %d', [0], i32(7), [1])), 'speed 7 of %d');
  assert.equal(text(bytes('%q', [0])), '%q');
});

test('control characters do not reach the page', () => {
  assert.equal(text(bytes('a\u001b[31m\nb', [0])), 'a [31m b');
});
