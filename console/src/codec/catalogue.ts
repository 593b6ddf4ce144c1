// All messages of RACK, by class and type. Bodies are decoded in the byte order that the flags of their header state,
// and encoded little endian, as encodeMessage() of tims/header.ts expects them.
import { flags as headerFlags, types } from '../tims/header';
import type { Bodies, Structs } from './messages';
import schema from './schema.json';
import { CodecError, type DecodeOptions, type Fields, Struct, type StructDescription } from './struct';

export interface Message {
  type: number;
  name: string;
  body?: Struct;
}

interface MessageDescription {
  type: number;
  name: string;
  body?: string;
}

const structs = new Map<string, Struct>();
for (const description of schema.structs as StructDescription[])
  structs.set(description.name, new Struct(description, structs));

const withBody = ({ type, name, body }: MessageDescription): Message => {
  const struct = body === undefined ? undefined : structs.get(body);
  return struct === undefined ? { type, name } : { type, name, body: struct };
};

const everyClass = (schema.every_class as MessageDescription[]).map(withBody);
const classes = new Map(
  schema.classes.map(({ id, name, messages }) => [
    id,
    { name, messages: (messages as MessageDescription[]).map(withBody) },
  ]),
);
const ids = new Map([...classes].map(([id, { name }]) => [name, id]));

export function className(id: number): string | undefined {
  return classes.get(id)?.name;
}

export function classId(name: string): number | undefined {
  return ids.get(name);
}

// The messages of a class; those that every class has are `messagesOf()`.
export function messagesOf(id?: number): readonly Message[] {
  return id === undefined ? everyClass : (classes.get(id)?.messages ?? []);
}

// By its type, or by its name: "MOVE".
export function findMessage(id: number, which: number | string): Message | undefined {
  const fits = ({ type, name }: Message) => type === which || name === which;
  return messagesOf(id).find(fits) ?? everyClass.find(fits);
}

export function structOf(name: keyof Structs): Struct {
  return structs.get(name)!;
}

function bodyOf(id: number, type: number): Struct {
  const body = findMessage(id, type)?.body;
  if (body === undefined)
    throw new CodecError(`${className(id) ?? `class ${id}`}: no body is known of messages of type ${type}`);
  return body;
}

export function decodeMessage(
  id: number,
  type: number,
  body: Uint8Array,
  flags: number,
  options?: DecodeOptions,
): Fields {
  return bodyOf(id, type).decode(body, (flags & headerFlags.bodyLittleEndian) !== 0, options);
}

export function decodeData(id: number, body: Uint8Array, flags: number, options?: DecodeOptions): Fields {
  return decodeMessage(id, types.data, body, flags, options);
}

export function decodeStruct<K extends keyof Structs>(name: K, body: Uint8Array, flags: number): Structs[K] {
  return structOf(name).decode(body, (flags & headerFlags.bodyLittleEndian) !== 0) as unknown as Structs[K];
}

// Fields that are missing have their defaults.
export function encodeMessage(id: number, type: number, value: object): Uint8Array<ArrayBuffer> {
  return bodyOf(id, type).encode(value as Fields);
}

// A message by CLASS.MESSAGE, or by the name of one that every class has.
export function findNamed(name: string): Message | undefined {
  const [of = '', message] = name.includes('.') ? name.split('.') : ['', name];
  return message === undefined ? undefined : findMessage(ids.get(of) ?? -1, message);
}

// Not by encodeMessage(): samples of sensors may hold numbers that are not finite, where nothing was measured.
export function encodeCommand({ body }: Message, value: Fields): Uint8Array<ArrayBuffer> {
  if (body === undefined) return new Uint8Array();
  refuseNotFinite(body.name, value);
  return body.encode(value);
}

function refuseNotFinite(name: string, value: unknown): void {
  if (value === null || (typeof value === 'number' && !Number.isFinite(value)))
    throw new CodecError(`${name} is ${value}: expected a number`);
  if (typeof value !== 'object' || ArrayBuffer.isView(value)) return;
  for (const [key, inner] of Object.entries(value)) refuseNotFinite(`${name}.${key}`, inner);
}

// A command. Its fields are checked by the compiler: encodeNamed('Chassis.MOVE', { vx: 200 }).
export function encodeNamed<K extends keyof Bodies & string>(
  name: K,
  value: Partial<NonNullable<Bodies[K]>> = {},
): { type: number; body: Uint8Array<ArrayBuffer> } {
  const message = findNamed(name)!;
  return { type: message.type, body: encodeCommand(message, value as Fields) };
}

interface Names {
  field: string;
  names: Record<string, number>;
  flags: Record<string, number>;
}

const values = new Map((schema.values as unknown as Names[]).map((names) => [names.field, names]));

// The names that a number may have, without its flags: for lists to choose from.
export function namesOf(field: string): [name: string, value: number][] {
  return Object.entries(values.get(field)?.names ?? {});
}

// What a number stands for: valueName('GpsData.mode', 18) is "3D, differential". Undefined: it is a plain number.
export function valueName(field: string, value: number): string | undefined {
  const known = values.get(field);
  if (known === undefined) return undefined;
  const flags = Object.entries(known.flags).filter(([, bit]) => (value & bit) !== 0);
  const rest = flags.reduce((left, [, bit]) => left & ~bit, value);
  const name = Object.entries(known.names).find(([, number]) => number === rest)?.[0] ?? (rest === 0 ? '' : `${rest}`);
  return [name, ...flags.map(([flag]) => flag)].filter((part) => part !== '').join(', ');
}
