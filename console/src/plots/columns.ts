// Curves for uPlot, which wants one list of times for all of them. Pure.
//
// What a curve has no sample for is undefined: its line goes on. Where a curve was silent, a null ends its line: the value
// that the router had kept from before, and the next one, are not joined.

import type { Ring } from './ring';

export interface Columns {
  times: number[];
  columns: (number | null | undefined)[][];
}

// `since`: the earliest time; `gap`: longer between two samples of a curve, its line ends. Both in s.
export function columnsOf(rings: readonly Ring[], since: number, gap: number): Columns {
  const curves = rings.map((ring) => curveOf(ring, since, gap));
  const times = [...new Set(curves.flatMap((curve) => [...curve.keys()]))].sort((a, b) => a - b);
  return { times, columns: curves.map((curve) => times.map((time) => curve.get(time))) };
}

function curveOf(ring: Ring, since: number, gap: number): Map<number, number | null> {
  const curve = new Map<number, number | null>();
  let before: number | undefined;
  ring.each((time, value) => {
    if (time < since) return;
    if (before !== undefined && time - before > gap) curve.set((before + time) / 2, null);
    curve.set(time, value);
    before = time;
  });
  return curve;
}
