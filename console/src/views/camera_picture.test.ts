import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { CameraData } from '../codec/messages';
import { decodePixels, isGrey, NewestPicture } from './camera_picture';
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
function pixel(data: CameraData, table?: string): number[] {
  const pixels = new Uint32Array(1);
  decodePixels(data, pixels, table ? colourTable(table) : undefined);
  return [...new Uint8Array(pixels.buffer)];
}

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
  assert.throws(() => pixel(picture(range, 7, [0])), /range cannot be shown/);
});

test('colours', () => {
  assert.deepEqual(pixel(picture(11, 24, [1, 2, 3])), [3, 2, 1, 255]);
  assert.deepEqual(pixel(picture(11, 24, [1, 2, 3]), 'grey to 63'), [3, 2, 1, 255]);
  assert.deepEqual(pixel(picture(12, 16, [0xff, 0xff])), [248, 252, 248, 255]);
  const yuv422 = 21;
  assert.deepEqual(pixel(picture(yuv422, 16, [128, 77, 128, 0])), [77, 77, 77, 255]);
  assert.deepEqual(pixel(picture(yuv422, 16, [0, 255, 255, 0])), [255, 208, 28, 255], 'cut off at white');
  assert.deepEqual(pixel(picture(yuv422, 16, [255, 0, 0, 0])), [0, 48, 225, 255], 'and at black');
  assert(!isGrey(picture(11, 24, [])));
  assert(isGrey(picture(1, 8, [])));
});

test('a picture that is decoded late is given up, and its memory given back', async () => {
  const ready: ((picture: ImageBitmap) => void)[] = [];
  const decoding = () => new Promise<ImageBitmap>((resolve) => ready.push(resolve));
  const closed: string[] = [];
  const bitmap = (name: string) => ({ name, close: () => closed.push(name) }) as unknown as ImageBitmap;
  const shown: unknown[] = [];
  const newest = new NewestPicture((each) => shown.push((each as unknown as { name: string }).name));
  const taken = ['first', 'second', 'third'].map(() => newest.take(decoding()));
  ready[1]?.(bitmap('second'));
  await taken[1];
  ready[0]?.(bitmap('first'));
  await taken[0];
  assert.deepEqual([shown, closed], [['second'], ['first']]);
  newest.end();
  ready[2]?.(bitmap('third'));
  await taken[2];
  assert.deepEqual([shown, closed], [['second'], ['first', 'third']]);
});
