// Changes of a file's text that leave all other bytes as they are.
//
// A text box shows every line end as "\n"; what is typed there is done on the text with its own line ends.

import type { Places } from './protocol';

export const shown = (text: string) => text.replace(/\r\n?/g, '\n');

// `text` with the change from shown(text) to `edited`.
export function retype(text: string, edited: string): string {
  const before = shown(text);
  if (before === edited) return text;
  let head = 0;
  const shorter = Math.min(before.length, edited.length);
  while (head < shorter && before[head] === edited[head]) ++head;
  let tail = 0;
  while (tail < shorter - head && before.at(-1 - tail) === edited.at(-1 - tail)) ++tail;
  const typed = edited.slice(head, edited.length - tail);
  return (
    text.slice(0, realOffset(text, head)) +
    typed.replaceAll('\n', lineEnd(text)) +
    text.slice(realOffset(text, before.length - tail))
  );
}

// Where the character at this offset of shown(text) is in the text.
function realOffset(text: string, offset: number): number {
  let real = 0;
  for (let i = 0; i < offset; ++i) real += text[real] === '\r' && text[real + 1] === '\n' ? 2 : 1;
  return real;
}

// That of the first line.
export function lineEnd(text: string): '\n' | '\r\n' {
  const end = text.indexOf('\n');
  return end > 0 && text[end - 1] === '\r' ? '\r\n' : '\n';
}

// The lines with their line ends.
export const linesOf = (text: string): string[] => text.match(/[^\n]*\n|[^\n]+$/g) ?? [];

// --- components, as they stand in a robot file: with their comments

export interface Cut {
  rest: string;
  block: string;
}

// Takes component `index` out of the text: from the comment right above its header to the next header's comment.
// Undefined: the places do not tell where it stands.
export function cutComponent(text: string, places: Places, index: number): Cut | undefined {
  const lines = linesOf(text);
  const header = headerLine(lines, places, `component[${index}]`);
  if (header === undefined) return undefined;
  const others = headerLines(lines, places).filter((line) => line > header && !isWithin(lines[line]));
  const begin = commentAbove(lines, header);
  const end = others[0] === undefined ? lines.length : commentAbove(lines, others[0]);
  return {
    block: lines.slice(begin, end).join(''),
    rest: lines.slice(0, begin).join('') + lines.slice(end).join(''),
  };
}

// Appends a component's lines behind the last component, with the text's line ends.
export function pasteComponent(text: string, block: string): string {
  const end = lineEnd(text);
  const lines = block.replace(/\r\n/g, '\n').replace(/\n+$/, '').replaceAll('\n', end);
  const body = text.replace(/(\r?\n)+$/, '');
  return body === '' ? lines + end : body + end + end + lines + end;
}

// The line of a table's header, from 0: places name values, so the header may be above the first of them.
function headerLine(lines: string[], places: Places, table: string): number | undefined {
  const own = places[table]?.[0];
  const firstValue = Object.entries(places)
    .filter(([path]) => path.startsWith(`${table}.`))
    .map(([, [line]]) => line);
  let line = (own ?? Math.min(...firstValue)) - 1;
  if (!Number.isFinite(line)) return undefined;
  while (line >= 0 && !isHeader(lines[line])) --line;
  return line >= 0 ? line : undefined;
}

// Lines that look like a header and stand in no text of several lines.
function headerLines(lines: string[], places: Places): number[] {
  const texts = textLines(lines);
  const known = new Set(Object.values(places).map(([line]) => line - 1));
  return lines.flatMap((line, i) => (isHeader(line) && (known.has(i) || !texts.has(i)) ? [i] : []));
}

// The lines within """...""" or '''...'''.
function textLines(lines: string[]): Set<number> {
  const within = new Set<number>();
  let quote: string | undefined;
  for (const [i, line] of lines.entries()) {
    if (quote !== undefined) within.add(i);
    const open = quote;
    for (const [found] of line.matchAll(/"""|'''/g)) {
      if (quote === undefined && !line.trimStart().startsWith('#')) quote = found;
      else if (quote === found) quote = undefined;
    }
    if (open === undefined && quote !== undefined) within.delete(i);
  }
  return within;
}

const isHeader = (line: string | undefined) => line !== undefined && /^\s*\[[^\]]/.test(line);

// [component.parameters] belongs to the component above it.
const isWithin = (line: string | undefined) => /^\s*\[\[?\s*component\s*\./.test(line ?? '');

// The first line of the comment that ends right above this line. A line that only titles a section ("# --- drivers")
// belongs to what follows it as a whole.
function commentAbove(lines: string[], header: number): number {
  let line = header;
  while (line > 0 && /^\s*#(?!\s*-{2,})/.test(lines[line - 1] ?? '')) --line;
  return line;
}
