// The bytes of a camera as pixels.

import { valueName } from '../codec/catalogue';
import type { CameraData } from '../codec/messages';

export const modeName = (mode: number) => valueName('CameraData.mode', mode) ?? `mode ${mode}`;

type Pixel = [red: number, green: number, blue: number];

export async function pictureOf(data: CameraData): Promise<ImageData | ImageBitmap> {
  if (modeName(data.mode) === 'jpeg') return createImageBitmap(new Blob([data.image.slice()], { type: 'image/jpeg' }));
  return new ImageData(pixelsOf(data), data.width, data.height);
}

// 4 bytes a pixel. Values of more than 8 bits are shown by their upper ones.
export function pixelsOf({ width, height, depth, mode, image }: CameraData): Uint8ClampedArray<ArrayBuffer> {
  const read = readers[modeName(mode)] ?? readers[`mono${depth}`];
  if (read === undefined) throw new Error(`pictures of ${modeName(mode)} cannot be shown`);
  const pixels = new Uint8ClampedArray(4 * width * height);
  if (width === 0 || height === 0) throw new Error('the picture has no pixels');
  for (let i = 0; i < width * height; ++i) {
    const [red, green, blue] = read(image, i);
    pixels[4 * i] = red;
    pixels[4 * i + 1] = green;
    pixels[4 * i + 2] = blue;
    pixels[4 * i + 3] = 255;
  }
  return pixels;
}

const grey = (value: number): Pixel => [value, value, value];
const at = (image: Uint8Array, i: number) => image[i] ?? 0;
const word = (image: Uint8Array, i: number) => at(image, 2 * i) | (at(image, 2 * i + 1) << 8);

const readers: Record<string, (image: Uint8Array, i: number) => Pixel> = {
  mono8: (image, i) => grey(at(image, i)),
  raw8: (image, i) => grey(at(image, i)),
  mono12: (image, i) => grey(word(image, i) >> 4),
  mono16: (image, i) => grey(word(image, i) >> 8),
  mono24: (image, i) => grey(at(image, 3 * i + 2)),
  // B, G, R in spite of its name.
  rgb24: (image, i) => [at(image, 3 * i + 2), at(image, 3 * i + 1), at(image, 3 * i)],
  rgb565: (image, i) => {
    const value = word(image, i);
    return [(value >> 8) & 0xf8, (value >> 3) & 0xfc, (value << 3) & 0xf8];
  },
  // U Y0 V Y1
  yuv422: (image, i) => {
    const pair = 4 * (i >> 1);
    const luma = at(image, pair + 1 + 2 * (i & 1));
    const u = at(image, pair) - 128;
    const v = at(image, pair + 2) - 128;
    return [luma + 1.402 * v, luma - 0.344 * u - 0.714 * v, luma + 1.772 * u];
  },
};
