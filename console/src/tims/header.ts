// The 16 bytes before the body of every message:
//
//   0 flags u8 | 1 type i8 | 2 priority u8 | 3 sequence number u8 | 4 dest u32 | 8 src u32 | 12 length u32
//
// Bit 0 of the flags is the byte order of dest, src and length, bit 1 that of the body; set: little endian.

import { every_class } from '../codec/schema.json';

export const headerSize = 16;

export const flags = {
  headerLittleEndian: 0x01,
  bodyLittleEndian: 0x02,
  stream: 0x10, // sample of a continuous stream
  trace: 0x20, // asks every router on the route for a hop record
  reportReason: 0x80, // the sender accepts a text after an ERROR
} as const;

// Of a message that every class has.
function numberOf(name: string): number {
  const found = every_class.find((message) => message.name === name);
  if (found === undefined) throw new Error(`schema.json has no message ${name}`);
  return found.type;
}

// Types with a meaning for all mailboxes.
export const types = {
  ok: numberOf('OK'),
  error: numberOf('ERROR'),
  timeout: numberOf('TIMEOUT'),
  notAvailable: numberOf('NOT_AVAILABLE'),
  enabled: numberOf('ENABLED'),
  disabled: numberOf('DISABLED'),
  data: -6, // each class has its own body
  contData: numberOf('CONT_DATA'),
  param: numberOf('PARAM'),
  on: numberOf('ON'),
  off: numberOf('OFF'),
  getStatus: numberOf('GET_STATUS'),
  getData: numberOf('GET_DATA'),
  getContData: numberOf('GET_CONT_DATA'),
  stopContData: numberOf('STOP_CONT_DATA'),
  getNextData: numberOf('GET_NEXT_DATA'),
  getParam: numberOf('GET_PARAM'),
  setParam: numberOf('SET_PARAM'),
  getDescription: numberOf('GET_DESCRIPTION'),
  getRuntime: numberOf('GET_RUNTIME'),
  getListeners: numberOf('GET_LISTENERS'),
  getParamEffects: numberOf('GET_PARAM_EFFECTS'),
  paramEffects: numberOf('PARAM_EFFECTS'),
  adminRequest: 64, // of routers
  adminReply: -64,
  hopRecord: -65,
} as const;

// 100 and more are for commands that stop a robot: they overtake everything else on each link.
export const stopPriority = 255;

// Commands of a client to its router, with dest = src = 0.
export const routerCommands = { registerMailbox: 13, deleteMailbox: 14, lifesign: 17 } as const;

// Of the samples of a stream that wait at the router for this connection, only the newest: in the body of
// registerMailbox, behind the address.
export const keepNewest = 1;

export interface Header {
  flags: number;
  type: number;
  priority: number;
  sequence: number;
  dest: number;
  src: number;
  length: number;
}

// Undefined: these bytes are no whole message.
export function decodeHeader(message: Uint8Array): Header | undefined {
  if (message.length < headerSize) return undefined;
  const view = new DataView(message.buffer, message.byteOffset, message.byteLength);
  const bits = view.getUint8(0);
  const little = (bits & flags.headerLittleEndian) !== 0;
  const header = {
    flags: bits,
    type: view.getInt8(1),
    priority: view.getUint8(2),
    sequence: view.getUint8(3),
    dest: view.getUint32(4, little),
    src: view.getUint32(8, little),
    length: view.getUint32(12, little),
  };
  return header.length === message.length ? header : undefined;
}

// A message with its header and body in little-endian byte order.
export function encodeMessage(header: Partial<Header>, body: Uint8Array = new Uint8Array()): Uint8Array<ArrayBuffer> {
  const message = new Uint8Array(headerSize + body.length);
  const view = new DataView(message.buffer);
  view.setUint8(0, (header.flags ?? 0) | flags.headerLittleEndian | flags.bodyLittleEndian);
  view.setInt8(1, header.type ?? 0);
  view.setUint8(2, header.priority ?? 0);
  view.setUint8(3, header.sequence ?? 0);
  view.setUint32(4, header.dest ?? 0, true);
  view.setUint32(8, header.src ?? 0, true);
  view.setUint32(12, message.length, true);
  message.set(body, headerSize);
  return message;
}

export function wordBody(...words: number[]): Uint8Array<ArrayBuffer> {
  const body = new Uint8Array(4 * words.length);
  const view = new DataView(body.buffer);
  for (const [i, word] of words.entries()) view.setUint32(4 * i, word >>> 0, true);
  return body;
}

// A 32-bit number of a body, in the byte order that its header states; undefined: the body is shorter.
export function wordAt(body: Uint8Array, offset: number, bits: number): number | undefined {
  if (body.length < offset + 4) return undefined;
  return new DataView(body.buffer, body.byteOffset).getUint32(offset, (bits & flags.bodyLittleEndian) !== 0);
}
