// The bytes of a camera as pixels. Pure, but for JPEG, which the browser decodes.

import { valueName } from '../codec/catalogue';
import type { CameraData } from '../codec/messages';
import { opaque } from '../map/points';
import type { ColourTable } from './colour_tables';

export const modeName = (mode: number) => valueName('CameraData.mode', mode) ?? `mode ${mode}`;

// The memory of the pictures of one view, one after the other: that of a new one has to be got from the system each time,
// which takes several times as long as its pixels do. A picture holds until the next one of the same memory is made.
export class PictureMemory {
  private pixels = new Uint32Array();

  async picture(data: CameraData, table?: ColourTable): Promise<ImageData | ImageBitmap> {
    if (modeName(data.mode) === 'jpeg')
      return createImageBitmap(new Blob([data.image.slice()], { type: 'image/jpeg' }));
    const { width, height } = data;
    if (this.pixels.length !== width * height) this.pixels = new Uint32Array(width * height);
    decodePixels(data, this.pixels, table);
    return new ImageData(new Uint8ClampedArray(this.pixels.buffer), width, height);
  }
}

// Pictures that are decoded at the same time may be ready in another order: one that is late is given up.
export class NewestPicture {
  private begun = 0;
  private shown = 0;

  constructor(private readonly show: (picture: ImageData | ImageBitmap) => void) {}

  // Throws why it cannot be decoded.
  async take(decoding: Promise<ImageData | ImageBitmap>): Promise<void> {
    const number = ++this.begun;
    const picture = await decoding;
    if (number < this.shown) return release(picture);
    this.shown = number;
    this.show(picture);
  }

  // Those that are being decoded are late from now on.
  end(): void {
    this.shown = Number.POSITIVE_INFINITY;
  }
}

// The memory of a decoded picture is not that of the script: it is given back at once, and not when many have piled up.
export function release(picture: ImageData | ImageBitmap | undefined): void {
  if (picture !== undefined && 'close' in picture) picture.close();
}

// Of values that have more than 8 bits the upper ones are shown, or the colours of a table. Throws why there is no picture.
export function decodePixels(data: CameraData, pixels: Uint32Array, table?: ColourTable): void {
  const { depth, mode, image } = data;
  const read = greyOf(modeName(mode), depth, table) ?? colours[modeName(mode)];
  if (read === undefined) throw new Error(`pictures of ${modeName(mode)} cannot be shown`);
  if (pixels.length === 0) throw new Error('the picture has no pixels');
  for (let i = 0; i < pixels.length; ++i) pixels[i] = read(image, i);
}

// The picture has one number a pixel, which a table of colours can be applied to.
export const isGrey = ({ mode, depth }: CameraData) => greyOf(modeName(mode), depth) !== undefined;

// A number of the camera, or a pixel: no object for each of a million pixels.
type Reader = (image: Uint8Array, i: number) => number;

const at = (image: Uint8Array, i: number) => image[i] ?? 0;
const word = (image: Uint8Array, i: number) => at(image, 2 * i) | (at(image, 2 * i + 1) << 8);

interface Numbers {
  value: Reader;
  bits: number;
}

const numbers: Record<string, Numbers> = {
  mono8: { value: at, bits: 8 },
  raw8: { value: at, bits: 8 },
  mono12: { value: word, bits: 12 },
  raw12: { value: word, bits: 12 },
  mono16: { value: word, bits: 16 },
  raw16: { value: word, bits: 16 },
  mono24: {
    value: (image, i) => at(image, 3 * i) | (at(image, 3 * i + 1) << 8) | (at(image, 3 * i + 2) << 16),
    bits: 24,
  },
};

// Images of ranges, types, edges ... have as many bits as their depth says.
function greyOf(mode: string, depth: number, table?: ColourTable): Reader | undefined {
  const found = numbers[mode] ?? (colours[mode] === undefined ? numbers[`mono${depth}`] : undefined);
  if (found === undefined) return undefined;
  const { value, bits } = found;
  if (table !== undefined) return (image, i) => opaque(...table(value(image, i)));
  const surplus = 2 ** (bits - 8);
  return (image, i) => {
    const level = byte(Math.floor(value(image, i) / surplus));
    return opaque(level, level, level);
  };
}

const byte = (value: number) => Math.max(0, Math.min(255, Math.round(value)));

const colours: Record<string, Reader> = {
  // B, G, R in spite of its name.
  rgb24: (image, i) => opaque(at(image, 3 * i + 2), at(image, 3 * i + 1), at(image, 3 * i)),
  rgb565: (image, i) => {
    const value = word(image, i);
    return opaque((value >> 8) & 0xf8, (value >> 3) & 0xfc, (value << 3) & 0xf8);
  },
  // U Y0 V Y1
  yuv422: (image, i) => {
    const pair = 4 * (i >> 1);
    const luma = at(image, pair + 1 + 2 * (i & 1));
    const u = at(image, pair) - 128;
    const v = at(image, pair + 2) - 128;
    return opaque(byte(luma + 1.402 * v), byte(luma - 0.344 * u - 0.714 * v), byte(luma + 1.772 * u));
  },
};
