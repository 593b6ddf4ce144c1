// A body as JSON: byte for byte what timsctl prints, so that texts of both can be compared.
import type { Value } from './numbers';
import { type Field, type Fields, listOf, type Struct } from './struct';
import { bytesOf } from './text';

const nobody = 0xffffff00; // no component

export type AddressText = (address: number) => string;

export function toJson(struct: Struct, value: Fields, addressText: AddressText): string {
  const fields = struct.fields.map((field) => {
    const text =
      field.type === 'count' ? `${struct.counted(field, value)}` : fieldJson(field, value[field.name], addressText);
    return `${quoted(field.name)}:${text}`;
  });
  return `{${fields.join(',')}}`;
}

function fieldJson(field: Field, value: unknown, addressText: AddressText): string {
  if (field.times === undefined && !field.isVariable) return oneJson(field, value, addressText);
  if (field.isVariable && field.type === 'char') return quoted(value as string);
  const list = listOf(field, value);
  if (field.isVariable && field.type === 'byte') return `"${hexOf(list as Uint8Array)}"`;
  return `[${Array.from(list, (element) => oneJson(field, element, addressText)).join(',')}]`;
}

function oneJson(field: Field, value: unknown, addressText: AddressText): string {
  if (field.inner !== undefined) return toJson(field.inner, value as Fields, addressText);
  if (field.number === undefined) return quoted(value as string);
  if (field.type === 'address') return value === nobody ? 'null' : quoted(addressText(value as number));
  return numberJson(value as Value, field.type === 'f32');
}

export function hexOf(bytes: Uint8Array): string {
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('');
}

function quoted(text: string): string {
  let out = '"';
  for (const byte of bytesOf(text)) {
    const c = String.fromCharCode(byte);
    if (c === '"' || c === '\\') out += `\\${c}`;
    else out += byte >= 0x20 && byte < 0x7f ? c : `\\u00${byte.toString(16).padStart(2, '0')}`;
  }
  return `${out}"`;
}

// The shortest decimal number that is this float: 0.1, where the number of JavaScript is 0.10000000149011612.
export function shortFloat(value: number): number {
  for (let digits = 0; digits < 8; ++digits) {
    const nearest = toEven(value, digits);
    const [mantissa, exponent] = nearest.split('e');
    // Below a power of two, floats are closer to each other than above, so that the nearest may not be the same float.
    const above = `${(Number(mantissa) + Math.sign(value) * 10 ** -digits).toFixed(digits)}e${exponent}`;
    for (const short of [Number(nearest), Number(above)]) if (Math.fround(short) === value) return short;
  }
  return Number(value.toExponential(8));
}

// As toExponential(), which rounds a half up.
function toEven(value: number, digits: number): string {
  const longer = value.toExponential(digits + 1);
  const isHalf = Number(longer) === value && /[02468]\.?5e/.test(longer);
  return isHalf ? longer.replace(/5e/, 'e') : value.toExponential(digits);
}

// As std::to_chars() writes it: the shorter of 0.00001 and 1e-05.
function numberJson(value: Value, isFloat32: boolean): string {
  if (typeof value === 'bigint') return `${value}`;
  if (!Number.isFinite(value)) return 'null';
  if (value === 0) return Object.is(value, -0) ? '-0' : '0';
  const [mantissa = '', exponent = 0] = (isFloat32 ? shortFloat(value) : value).toExponential().split('e');
  const scientific = `${mantissa}e${Number(exponent) < 0 ? '-' : '+'}${`${Math.abs(Number(exponent))}`.padStart(2, '0')}`;
  const fixed = fixedText(mantissa, Number(exponent), value);
  return fixed.length <= scientific.length ? fixed : scientific;
}

function fixedText(mantissa: string, exponent: number, value: number): string {
  const sign = mantissa.startsWith('-') ? '-' : '';
  const digits = mantissa.replace(/[-.]/g, '');
  if (exponent < 0) return `${sign}0.${'0'.repeat(-exponent - 1)}${digits}`;
  const whole = exponent + 1;
  // All digits of a large number are exact, as in C++.
  if (digits.length <= whole) return `${BigInt(value)}`;
  return `${sign}${digits.slice(0, whole)}.${digits.slice(whole)}`;
}
