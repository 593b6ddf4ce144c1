// Lists of structs without an object for each: scans of hundreds of points arrive many times a second, and garbage is
// what they would cost. The numbers lie as they were sent, in the machine's byte order:
//
//   const { points } = decode('LadarData', body, little, { elements: true });
//   const { distance } = points.index;
//   for (let i = 0; i < points.length; ++i) use(points.i32[i * points.step4 + distance]);
import type { Struct } from './struct';

export interface Elements<T = Record<string, unknown>> {
  length: number;
  // From an element to the next, in numbers of 4, 2 and 1 bytes.
  step4: number;
  step2: number;
  step1: number;
  // Where a field is in an element, in numbers of its own size. Fields of inner structs: "pos.x".
  index: Readonly<Record<keyof T & string, number>>;
  i32: Int32Array;
  u32: Uint32Array;
  f32: Float32Array;
  i16: Int16Array;
  u16: Uint16Array;
  bytes: Uint8Array;
}

interface Layout {
  index: Record<string, number>;
  swaps: [at: number, size: number][]; // numbers of an element of more than one byte
}

const layouts = new WeakMap<Struct, Layout | null>();
const machineIsLittle = new Uint8Array(Uint32Array.of(1).buffer)[0] === 1;

// Undefined: the struct has fields that no typed array can show.
export function elementsOf(struct: Struct, bytes: Uint8Array, little: boolean): Elements | undefined {
  const layout = layoutOf(struct);
  if (layout === null) return undefined;
  const isAsHere = little === machineIsLittle;
  const here = isAsHere && bytes.byteOffset % 4 === 0 ? bytes : bytes.slice();
  if (!isAsHere) swap(here, struct.size, layout);
  const { buffer, byteOffset, length } = here;
  return {
    length: length / struct.size,
    step4: struct.size / 4,
    step2: struct.size / 2,
    step1: struct.size,
    index: layout.index,
    i32: new Int32Array(buffer, byteOffset, length / 4),
    u32: new Uint32Array(buffer, byteOffset, length / 4),
    f32: new Float32Array(buffer, byteOffset, length / 4),
    i16: new Int16Array(buffer, byteOffset, length / 2),
    u16: new Uint16Array(buffer, byteOffset, length / 2),
    bytes: here,
  };
}

function layoutOf(struct: Struct): Layout | null {
  let layout = layouts.get(struct);
  if (layout === undefined) {
    const found: Layout = { index: {}, swaps: [] };
    layout = collect(struct, 0, '', found) && struct.size % 4 === 0 ? found : null;
    layouts.set(struct, layout);
  }
  return layout;
}

function collect(struct: Struct, start: number, prefix: string, layout: Layout): boolean {
  let at = start;
  for (const field of struct.fields) {
    const name = prefix + field.name;
    if (field.inner !== undefined && field.times === undefined) {
      if (!collect(field.inner, at, `${name}.`, layout)) return false;
    } else {
      if (field.number === undefined || field.size > 4 || at % field.size !== 0) return false;
      layout.index[name] = at / field.size;
      for (let i = 0; i < field.most && field.size > 1; ++i) layout.swaps.push([at + i * field.size, field.size]);
    }
    at += field.size * field.most;
  }
  return true;
}

function swap(bytes: Uint8Array, step: number, { swaps }: Layout): void {
  for (let element = 0; element < bytes.length; element += step)
    for (const [at, size] of swaps)
      for (let low = element + at, high = low + size - 1; low < high; ++low, --high) {
        const byte = bytes[low]!;
        bytes[low] = bytes[high]!;
        bytes[high] = byte;
      }
}
