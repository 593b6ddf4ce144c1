// The bytes of a camera as pixels.

import type { CameraData } from '../codec/messages';

// The modes of class Camera.
const mode = { mono8: 1, mono12: 2, mono16: 3, mono24: 4, rgb24: 11, rgb565: 12, yuv422: 21, raw8: 31, jpeg: 41 };
export const modes: Record<number, string> = Object.fromEntries(
  Object.entries({ ...mode, raw12: 32, raw16: 33, range: 51, disparity: 59 }).map(([name, number]) => [number, name]),
);

type Pixel = [red: number, green: number, blue: number];

export async function pictureOf(data: CameraData): Promise<ImageData | ImageBitmap> {
  if (data.mode === mode.jpeg) return createImageBitmap(new Blob([data.image.slice()], { type: 'image/jpeg' }));
  return new ImageData(pixelsOf(data), data.width, data.height);
}

// 4 bytes a pixel. Values of more than 8 bits are shown by their upper ones.
export function pixelsOf({ width, height, depth, mode: kind, image }: CameraData): Uint8ClampedArray<ArrayBuffer> {
  const read = readers[kind] ?? (depth === 8 ? readers[mode.mono8] : depth === 16 ? readers[mode.mono16] : undefined);
  if (read === undefined) throw new Error(`pictures of mode ${modes[kind] ?? kind} cannot be shown`);
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

const readers: Record<number, (image: Uint8Array, i: number) => Pixel> = {
  [mode.mono8]: (image, i) => grey(at(image, i)),
  [mode.raw8]: (image, i) => grey(at(image, i)),
  [mode.mono12]: (image, i) => grey(word(image, i) >> 4),
  [mode.mono16]: (image, i) => grey(word(image, i) >> 8),
  [mode.mono24]: (image, i) => grey(at(image, 3 * i + 2)),
  // B, G, R in spite of its name.
  [mode.rgb24]: (image, i) => [at(image, 3 * i + 2), at(image, 3 * i + 1), at(image, 3 * i)],
  [mode.rgb565]: (image, i) => {
    const value = word(image, i);
    return [(value >> 8) & 0xf8, (value >> 3) & 0xfc, (value << 3) & 0xf8];
  },
  // U Y0 V Y1
  [mode.yuv422]: (image, i) => {
    const pair = 4 * (i >> 1);
    const luma = at(image, pair + 1 + 2 * (i & 1));
    const u = at(image, pair) - 128;
    const v = at(image, pair + 2) - 128;
    return [luma + 1.402 * v, luma - 0.344 * u - 0.714 * v, luma + 1.772 * u];
  },
};
