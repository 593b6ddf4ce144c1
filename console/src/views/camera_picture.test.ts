import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { CameraData } from '../codec/messages';
import { isGrey, pixelsOf } from './camera_picture';
import { colourTable } from './colour_tables';

const picture = (mode: number, depth: number, bytes: number[]): CameraData => ({
  recordingTime: 0,
  width: 1,
  height: 1,
  depth,
  mode,
  colorFilterId: 0,
  image: Uint8Array.from(bytes),
});
const pixel = (data: CameraData, table?: string) => [...pixelsOf(data, table ? colourTable(table) : undefined)];

test('a grey level is shown by its upper 8 bits', () => {
  assert.deepEqual(pixel(picture(1, 8, [200])), [200, 200, 200, 255]);
  assert.deepEqual(pixel(picture(2, 12, [0xff, 0x0f])), [255, 255, 255, 255]);
  assert.deepEqual(pixel(picture(3, 16, [0xff, 0x80])), [128, 128, 128, 255]);
  assert.deepEqual(pixel(picture(4, 24, [0xff, 0xff, 0x07])), [7, 7, 7, 255]);
});

test('a table colours the whole number', () => {
  assert.deepEqual(pixel(picture(3, 16, [0xe8, 0x03]), 'range indoors'), [0, 0, 255, 255]);
});

test('modes of images without a name here are read by their depth', () => {
  const range = 51;
  assert.deepEqual(pixel(picture(range, 16, [0, 0x40])), [64, 64, 64, 255]);
  assert.throws(() => pixelsOf(picture(range, 7, [0])), /range cannot be shown/);
});

test('colours', () => {
  assert.deepEqual(pixel(picture(11, 24, [1, 2, 3])), [3, 2, 1, 255]);
  assert.deepEqual(pixel(picture(11, 24, [1, 2, 3]), 'grey to 63'), [3, 2, 1, 255]);
  assert(!isGrey(picture(11, 24, [])));
  assert(isGrey(picture(1, 8, [])));
});
