// The numbers of messages, by the names of their types in schema.json.

export type Value = number | bigint;

export interface NumberType {
  size: number;
  min: Value; // of floats and their max: 0
  max: Value;
  isFloat: boolean;
  read(view: DataView, at: number, little: boolean): Value;
  write(view: DataView, at: number, value: Value, little: boolean): void;
}

// Numbers of 64 bits that a number would not hold exactly are bigint.
function exact(value: bigint): Value {
  const number = Number(value);
  return Number.isSafeInteger(number) ? number : value;
}

type Kind = 'Int8' | 'Uint8' | 'Int16' | 'Uint16' | 'Int32' | 'Uint32' | 'Float32' | 'Float64';

function plain(kind: Kind, size: number): NumberType {
  const isFloat = kind.startsWith('F');
  const span = 2 ** (8 * size);
  const min = kind.startsWith('I') ? -span / 2 : 0;
  return {
    size,
    min: isFloat ? 0 : min,
    max: isFloat ? 0 : min + span - 1,
    isFloat,
    read: (view, at, little) => view[`get${kind}`](at, little),
    write: (view, at, value, little) => view[`set${kind}`](at, Number(value), little),
  };
}

function big(kind: 'BigInt64' | 'BigUint64', min: bigint, max: bigint): NumberType {
  return {
    size: 8,
    min,
    max,
    isFloat: false,
    read: (view, at, little) => exact(view[`get${kind}`](at, little)),
    write: (view, at, value, little) => view[`set${kind}`](at, BigInt(value), little),
  };
}

const u8 = plain('Uint8', 1);
const i32 = plain('Int32', 4);
const u32 = plain('Uint32', 4);

export const numberTypes: Readonly<Record<string, NumberType>> = {
  i8: plain('Int8', 1),
  u8,
  i16: plain('Int16', 2),
  u16: plain('Uint16', 2),
  i32,
  u32,
  i64: big('BigInt64', -(2n ** 63n), 2n ** 63n - 1n),
  u64: big('BigUint64', 0n, 2n ** 64n - 1n),
  f32: plain('Float32', 4),
  f64: plain('Float64', 8),
  byte: u8,
  char: u8,
  count: i32,
  time: u32,
  address: u32,
};
