// Which lines two texts have in common, and the merge of two changes of one text.

import { linesOf } from './text';

interface Hunk {
  begin: number; // lines of the base
  end: number;
  lines: string[]; // instead of them
}

export interface Merge {
  text: string;
  // Lines that both have changed: ours are kept.
  clashes: { line: number; ours: string; theirs: string }[];
}

const cellsMax = 4e6; // of the table of common lines

export function merge(base: string, ours: string, theirs: string): Merge {
  const lines = linesOf(base);
  const mine = hunks(lines, linesOf(ours));
  const other = hunks(lines, linesOf(theirs));
  const merged: string[] = [];
  const clashes: Merge['clashes'] = [];
  let at = 0;
  const copyTo = (line: number) => {
    merged.push(...lines.slice(at, line));
    at = Math.max(at, line);
  };
  while (mine.length > 0 || other.length > 0) {
    const [a, b] = [mine[0], other[0]];
    if (a !== undefined && b !== undefined && overlap(a, b)) {
      const [begin, end] = grow(mine, other);
      const own = takeAll(mine, begin, end, lines);
      const their = takeAll(other, begin, end, lines);
      copyTo(begin);
      if (own.join('') !== their.join(''))
        clashes.push({ line: merged.length + 1, ours: own.join(''), theirs: their.join('') });
      merged.push(...own);
      at = end;
      continue;
    }
    const from = b === undefined || (a !== undefined && a.begin <= b.begin) ? mine : other;
    const hunk = from.shift()!;
    copyTo(hunk.begin);
    merged.push(...hunk.lines);
    at = hunk.end;
  }
  copyTo(lines.length);
  return { text: merged.join(''), clashes };
}

const overlap = (a: Hunk, b: Hunk) => (a.begin < b.end && b.begin < a.end) || a.begin === b.begin;

// The lines of the base that the first hunks of both change together.
function grow(mine: Hunk[], other: Hunk[]): [number, number] {
  const begin = Math.min(mine[0]!.begin, other[0]!.begin);
  let end = Math.max(mine[0]!.end, other[0]!.end);
  for (let more = true; more; ) {
    more = false;
    for (const hunk of [...mine, ...other])
      if (hunk.begin < end && hunk.end > end) {
        end = hunk.end;
        more = true;
      }
  }
  return [begin, end];
}

// What one side has instead of these lines; its hunks there are taken away.
function takeAll(list: Hunk[], begin: number, end: number, lines: string[]): string[] {
  const result: string[] = [];
  let at = begin;
  while (list[0] !== undefined && (list[0].begin < end || list[0].begin === begin) && list[0].end <= end) {
    const hunk = list.shift()!;
    result.push(...lines.slice(at, hunk.begin), ...hunk.lines);
    at = hunk.end;
  }
  result.push(...lines.slice(at, end));
  return result;
}

function hunks(from: string[], to: string[]): Hunk[] {
  let head = 0;
  while (head < from.length && head < to.length && from[head] === to[head]) ++head;
  let tail = 0;
  while (tail < Math.min(from.length, to.length) - head && from.at(-1 - tail) === to.at(-1 - tail)) ++tail;
  const a = from.slice(head, from.length - tail);
  const b = to.slice(head, to.length - tail);
  if (a.length === 0 && b.length === 0) return [];
  if (a.length * b.length > cellsMax) return [{ begin: head, end: head + a.length, lines: b }];
  return differences(a, b).map(({ begin, end, lines }) => ({ begin: begin + head, end: end + head, lines }));
}

// By the longest common subsequence.
function differences(a: string[], b: string[]): Hunk[] {
  const width = b.length + 1;
  const common = new Uint32Array((a.length + 1) * width);
  const at = (i: number, j: number) => common[i * width + j]!;
  for (let i = a.length - 1; i >= 0; --i)
    for (let j = b.length - 1; j >= 0; --j)
      common[i * width + j] = a[i] === b[j] ? at(i + 1, j + 1) + 1 : Math.max(at(i + 1, j), at(i, j + 1));
  const result: Hunk[] = [];
  let open: Hunk | undefined;
  let i = 0;
  let j = 0;
  while (i < a.length || j < b.length) {
    if (i < a.length && j < b.length && a[i] === b[j]) {
      open = undefined;
      ++i;
      ++j;
      continue;
    }
    if (open === undefined) {
      open = { begin: i, end: i, lines: [] };
      result.push(open);
    }
    if (j >= b.length || (i < a.length && at(i + 1, j) >= at(i, j + 1))) open.end = ++i;
    else open.lines.push(b[j++]!);
  }
  return result;
}
