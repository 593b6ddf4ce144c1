// Any message struct to and from bytes, in either byte order, by its description in schema.json. Lengths in a body are
// not trusted: the error names the field, and no memory is taken for elements that are not there. The texts of errors
// are those of the C++ codec.
import { type NumberType, numberTypes, type Value } from './numbers';
import { tailSizes } from './tails';
import { bytesOf, textOf } from './text';
import { elementsOf } from './views';

export class CodecError extends Error {}

// As in schema.json.
export interface FieldDescription {
  name: string;
  type: string;
  bytes?: number; // of a text
  times?: number; // elements of an array
  at_most?: number; // of a sequence
  tail_at_most?: number;
  unit?: string;
  si_unit?: string;
  si?: number; // one unit in SI units
}
export interface StructDescription {
  name: string;
  whole_size?: number;
  pads?: number;
  surplus?: number;
  made: string;
  fields: FieldDescription[];
}

export interface Field extends FieldDescription {
  readonly inner?: Struct;
  readonly number?: NumberType;
  readonly size: number; // bytes of an element
  readonly most: number; // elements
  readonly isVariable: boolean;
}

export type Fields = Record<string, unknown>;

export interface DecodeOptions {
  // Lists of structs become Elements, which lie on the body: for scans.
  elements?: boolean;
}

interface Source {
  bytes: Uint8Array;
  view: DataView;
  at: number;
  little: boolean;
}

const advice = '; its sender is broken, or has another version of this message';

const viewOf = (bytes: Uint8Array) => new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);

export class Struct {
  readonly name: string;
  readonly fields: Field[];
  readonly size: number; // bytes, without the elements of sequences and tails
  private default: Fields | undefined;

  // `structs`: those that it may contain.
  constructor(
    private readonly description: StructDescription,
    structs: ReadonlyMap<string, Struct>,
  ) {
    this.name = description.name;
    this.fields = description.fields.map((field) => completed(description.name, field, structs));
    this.size = this.fields.reduce((size, f) => size + (f.isVariable ? 0 : f.size * f.most), 0);
    const hasTail = description.fields.some((field) => field.tail_at_most !== undefined);
    if (hasTail && tailSizes[this.name] === undefined) throw new CodecError(`${this.name}: tails.ts lacks its lengths`);
  }

  decode(body: Uint8Array, little: boolean, options: DecodeOptions = {}): Fields {
    if (body.length < this.size)
      throw new CodecError(`${this.name} has at least ${this.size} bytes, not ${body.length} bytes${advice}`);
    const source = { bytes: body, view: viewOf(body), at: 0, little };
    const value: Fields = {};
    let counter: Field | undefined;
    let tails = 0;
    for (const field of this.fields) {
      if (!field.isVariable) value[field.name] = readFixed(field, source);
      else if (field.tail_at_most === undefined)
        value[field.name] = this.readElements(
          field,
          counter?.name,
          Number(value[counter?.name ?? ''] ?? 0),
          source,
          options,
        );
      else value[field.name] = this.readElements(field, field.name, this.tails(value)[tails++]!, source, options);
      if (field.type === 'count') counter = field;
    }
    const { whole_size, surplus = 0 } = this.description;
    const { length } = body;
    if (length !== source.at && length !== whole_size && !(surplus > 0 && length === source.at + surplus))
      throw new CodecError(`${this.name} is ${source.at} bytes long by its own counts, not ${length} bytes${advice}`);
    return value;
  }

  // Fields that are missing have their defaults; counts are those of the sequences.
  encode(given: Fields, little = true): Uint8Array<ArrayBuffer> {
    const value = { ...this.made(), ...given };
    const lists = this.fields
      .filter((field) => field.isVariable)
      .map((field) => [field, this.list(field, value)] as const);
    const size = lists.reduce((sum, [field, list]) => sum + field.size * list.length, this.size);
    const bytes = new Uint8Array(
      Math.max(size, (this.description.pads ?? 0) > 0 ? (this.description.whole_size ?? 0) : 0),
    );
    const target = { bytes, view: viewOf(bytes), at: 0, little };
    for (const field of this.fields) {
      if (field.type === 'count') writeOne(field, this.name, this.counted(field, value), target);
      else if (!field.isVariable) writeFixed(field, this.name, value[field.name], target);
      else writeList(field, this.name, value[field.name], target);
    }
    return bytes;
  }

  made(): Fields {
    this.default ??= this.decode(bytesOfHex(this.description.made), true);
    return structuredClone(this.default);
  }

  // The number of elements of the sequence that a count belongs to: the next one.
  counted(count: Field, value: Fields): number {
    const next = this.fields.slice(this.fields.indexOf(count)).find((field) => field.at_most !== undefined);
    return next === undefined ? 0 : listOf(next, value[next.name]).length;
  }

  private tails(value: Fields): number[] {
    return tailSizes[this.name]!(value);
  }

  private list(field: Field, value: Fields): ArrayLike<unknown> {
    const list = listOf(field, value[field.name]);
    const name = `${this.name}.${field.name}`;
    if (list.length > field.most)
      throw new CodecError(`${name} has ${list.length} elements, allowed are ${field.most}: send fewer`);
    if (field.tail_at_most === undefined) return list;
    const stated = this.tails(value)[this.fields.filter((f) => f.tail_at_most !== undefined).indexOf(field)];
    if (stated !== list.length)
      throw new CodecError(
        `${name} has ${list.length} elements, but the other fields give ${stated}: correct one of them`,
      );
    return list;
  }

  private readElements(
    field: Field,
    count: string | undefined,
    length: number,
    source: Source,
    options: DecodeOptions,
  ): unknown {
    const name = `${this.name}.${count ?? field.name}`;
    if (!(length >= 0 && length <= field.most))
      throw new CodecError(`${name} is ${length}, allowed are 0 to ${field.most}${advice}`);
    const needed = length * field.size;
    const left = source.bytes.length - source.at;
    if (needed > left) throw new CodecError(`${name} needs ${needed} bytes, only ${left} bytes follow${advice}`);
    if (options.elements && field.inner !== undefined) {
      const view = elementsOf(field.inner, source.bytes.subarray(source.at, source.at + needed), source.little);
      if (view !== undefined) {
        source.at += needed;
        return view;
      }
    }
    return readMany(field, length, source);
  }
}

function completed(struct: string, field: FieldDescription, structs: ReadonlyMap<string, Struct>): Field {
  const most = field.times ?? field.at_most ?? field.tail_at_most ?? 1;
  const isVariable = field.at_most !== undefined || field.tail_at_most !== undefined;
  if (field.type === 'text') return { ...field, most, isVariable, size: field.bytes ?? 0 };
  const number = numberTypes[field.type];
  if (number !== undefined) return { ...field, most, isVariable, size: number.size, number };
  const inner = structs.get(field.type);
  if (inner === undefined) throw new CodecError(`${struct}.${field.name}: there is no type ${field.type}`);
  return { ...field, most, isVariable, size: inner.size, inner };
}

export function bytesOfHex(hex: string): Uint8Array {
  return Uint8Array.from(hex.match(/../g) ?? [], (digits) => Number.parseInt(digits, 16));
}

// --- reading; that the bytes are there has been checked

function readOne(field: Field, source: Source): unknown {
  const at = source.at;
  if (field.inner !== undefined) {
    const value: Fields = {};
    for (const inner of field.inner.fields) value[inner.name] = readFixed(inner, source);
    return value;
  }
  source.at += field.size;
  if (field.number !== undefined) return field.number.read(source.view, at, source.little);
  const text = source.bytes.subarray(at, at + field.size - 1);
  const end = text.indexOf(0);
  return textOf(end < 0 ? text : text.subarray(0, end));
}

function readFixed(field: Field, source: Source): unknown {
  return field.times === undefined ? readOne(field, source) : readMany(field, field.times, source);
}

function readMany(field: Field, length: number, source: Source): unknown {
  if (field.isVariable && field.number?.size === 1 && field.type !== 'i8') {
    const bytes = source.bytes.subarray(source.at, source.at + length);
    source.at += length;
    return field.type === 'char' ? textOf(bytes) : bytes;
  }
  const list: unknown[] = [];
  for (let i = 0; i < length; ++i) list.push(readOne(field, source));
  return list;
}

// --- writing

// What a list is sent as: a text as its bytes.
export function listOf(field: Field, value: unknown): ArrayLike<unknown> {
  if (field.type === 'char') return bytesOf(String(value));
  if (Array.isArray(value) || value instanceof Uint8Array) return value;
  throw new CodecError(`${field.name} is not a list`);
}

function writeList(field: Field, struct: string, value: unknown, target: Source): void {
  const list = listOf(field, value);
  if (list instanceof Uint8Array && field.size === 1) {
    target.bytes.set(list, target.at);
    target.at += list.length;
  } else for (let i = 0; i < list.length; ++i) writeOne(field, struct, list[i], target);
}

function writeFixed(field: Field, struct: string, value: unknown, target: Source): void {
  if (field.times === undefined) return writeOne(field, struct, value, target);
  const { length } = listOf(field, value);
  if (length !== field.times)
    throw new CodecError(`${struct}.${field.name} has ${length} elements, not ${field.times}`);
  writeList(field, struct, value, target);
}

function writeOne(field: Field, struct: string, value: unknown, target: Source): void {
  const name = `${struct}.${field.name}`;
  if (field.inner !== undefined) {
    if (typeof value !== 'object' || value === null) throw new CodecError(`${name} is not a ${field.type}`);
    const whole = { ...field.inner.made(), ...value };
    for (const inner of field.inner.fields) writeFixed(inner, field.inner.name, whole[inner.name], target);
    return;
  }
  if (field.number !== undefined) {
    field.number.write(target.view, target.at, checked(field.number, name, value), target.little);
  } else {
    const bytes = bytesOf(String(value));
    if (bytes.length >= field.size)
      throw new CodecError(`${name} has ${bytes.length} bytes, allowed are ${field.size - 1}: shorten it`);
    target.bytes.set(bytes, target.at);
  }
  target.at += field.size;
}

// null is a float that is not finite, as in JSON.
function checked(type: NumberType, name: string, value: unknown): Value {
  if (type.isFloat && value === null) return Number.NaN;
  const isNumber = typeof value === 'number' || typeof value === 'bigint';
  if (isNumber && type.isFloat) return value;
  const isWhole = typeof value === 'bigint' || Number.isInteger(value);
  if (isNumber && isWhole && value >= type.min && value <= type.max) return value;
  const expected = type.isFloat ? 'a number' : `a whole number from ${type.min} to ${type.max}`;
  throw new CodecError(`${name} is ${String(value)}: expected ${expected}`);
}
