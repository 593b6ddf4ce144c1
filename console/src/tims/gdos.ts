// The log texts of components (class GDOS): a format like printf's, and the raw values of its arguments behind it.
//
// Senders differ in two ways that the bytes do not announce. A pointer has 8 bytes or 4. And C programs of the
// original let the argument after a text overwrite that text's NUL, which leaves one stray byte at the end. So all
// four layouts are tried: the first whose arguments use up the body exactly is taken. Pure.

import { flags } from './header';

export type Level = 'print' | 'error' | 'warning' | 'info' | 'detail';

const levels: Record<number, Level> = {
  [-124]: 'print',
  [-125]: 'error',
  [-126]: 'warning',
  [-127]: 'info',
  [-128]: 'detail',
};

// By the type of a message to the sink, or by the level of a log's data.
export function levelOf(type: number): Level | undefined {
  return levels[type];
}

interface Layout {
  pointer: 4 | 8;
  textsWithoutEnd: boolean;
}

const layouts: Layout[] = [
  { pointer: 8, textsWithoutEnd: false },
  { pointer: 4, textsWithoutEnd: false },
  { pointer: 8, textsWithoutEnd: true },
  { pointer: 4, textsWithoutEnd: true },
];

// Width and precision are skipped, as by the original.
const conversion = /%[0-9.-]*([a-zA-Z%])/g;

// `name`: the text of an address. A text whose arguments are broken is returned as far as it could be read.
export function gdosText(body: Uint8Array, bits: number, name: (address: number) => string): string {
  const end = body.indexOf(0);
  if (end < 0) return oneLine(decoded(body)); // Java programs send the format only
  const format = decoded(body.subarray(0, end));
  const values = body.subarray(end + 1);
  const little = (bits & flags.bodyLittleEndian) !== 0;
  let best = format;
  for (const [i, layout] of layouts.entries()) {
    const { text, fits } = formatted(format, new Arguments(values, little, layout, name));
    if (fits) return oneLine(text);
    if (i === 0) best = text;
  }
  return oneLine(best);
}

function formatted(format: string, values: Arguments): { text: string; fits: boolean } {
  let text = '';
  let at = 0;
  for (const match of format.matchAll(conversion)) {
    text += format.slice(at, match.index);
    at = match.index + match[0].length;
    const kind = match[1] ?? '';
    const value = kind === '%' ? '%' : values.next(kind, format.slice(at));
    if (value === undefined) return { text: text + match[0], fits: false };
    text += value;
  }
  return { text: text + format.slice(at), fits: values.isUsedUp };
}

class Arguments {
  private at = 0;
  private hasStrayByte = false;
  private readonly view: DataView;

  constructor(
    private readonly bytes: Uint8Array,
    private readonly little: boolean,
    private readonly layout: Layout,
    private readonly name: (address: number) => string,
  ) {
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  get isUsedUp(): boolean {
    return this.bytes.length - this.at === (this.hasStrayByte ? 1 : 0);
  }

  // `rest`: the format after this conversion.
  next(kind: string, rest: string): string | undefined {
    if (kind === 's') return this.text(rest);
    const size = sizeOf(kind, this.layout);
    if (size === undefined || this.at + size > this.bytes.length) return undefined;
    const at = this.at;
    this.at += size;
    switch (kind) {
      case 'x':
      case 'X':
        return this.view.getUint32(at, this.little).toString(16);
      case 'b':
        return this.view.getUint32(at, this.little).toString(2);
      case 'n':
        return this.name(this.view.getUint32(at, this.little));
      case 'p':
        return `0x${(size === 8 ? this.view.getBigUint64(at, this.little) : this.view.getUint32(at, this.little)).toString(16)}`;
      case 'f':
        return this.view.getFloat64(at, this.little).toFixed(3);
      case 'a':
        return ((this.view.getFloat64(at, this.little) * 180) / Math.PI).toFixed(2);
      case 'L':
        return `${this.view.getBigInt64(at, this.little)}`;
      default:
        return `${this.view.getInt32(at, this.little)}`;
    }
  }

  private text(rest: string): string | undefined {
    const behind = this.sizeOfRest(rest);
    const left = this.bytes.subarray(this.at);
    if (this.layout.textsWithoutEnd && behind > 0) {
      const size = left.length - behind - 1;
      if (size < 0) return undefined;
      this.hasStrayByte = true;
      this.at += size;
      return decoded(left.subarray(0, size));
    }
    const end = left.indexOf(0);
    if (end < 0) return undefined;
    this.at += end + 1;
    return decoded(left.subarray(0, end));
  }

  // 0: there are no arguments, or one of them is a text.
  private sizeOfRest(rest: string): number {
    let size = 0;
    for (const [, kind = ''] of rest.matchAll(conversion)) {
      if (kind === '%') continue;
      const needed = sizeOf(kind, this.layout);
      if (needed === undefined) return 0;
      size += needed;
    }
    return size;
  }
}

function sizeOf(kind: string, layout: Layout): number | undefined {
  if ('diuxXbn'.includes(kind)) return 4;
  if ('faL'.includes(kind)) return 8;
  return kind === 'p' ? layout.pointer : undefined;
}

const decoded = (bytes: Uint8Array) => new TextDecoder().decode(bytes);

function oneLine(text: string): string {
  // biome-ignore lint/suspicious/noControlCharactersInRegex: these are what is removed
  return text.replace(/[\u0000-\u001f\u007f]/g, ' ').trimEnd();
}
