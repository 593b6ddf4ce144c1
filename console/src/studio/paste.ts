// Cells from a spread sheet: one value a line goes into the rows below each other; "name<TAB>value" into the row of
// that name.

export interface PastedValue {
  row: number;
  value: string;
}

export interface Pasted {
  values: PastedValue[];
  unknown: string[]; // names without a row, and lines without one
}

// `names`: of all rows, as they stand on the screen. `first`: the row that was pasted into.
export function paste(text: string, names: string[], first: number): Pasted {
  const lines = text.replace(/\r\n?/g, '\n').replace(/\n+$/, '').split('\n');
  const result: Pasted = { values: [], unknown: [] };
  for (const [i, line] of lines.entries()) {
    const cells = line.split('\t').map((cell) => cell.trim());
    const row = cells.length > 1 ? rowOf(cells[0] ?? '', names, first) : first + i;
    if (row < 0 || row >= names.length) result.unknown.push(cells[0] ?? '');
    else result.values.push({ row, value: cells.at(-1) ?? '' });
  }
  return result;
}

// A name may stand in several rows, of several components: that at or below the first row.
function rowOf(name: string, names: string[], first: number): number {
  const below = names.indexOf(name, first);
  return below >= 0 ? below : names.indexOf(name);
}

export const isSeveral = (text: string) => /[\t\n]/.test(text.trim());
