import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';

type Triple = [number, number, number];

// What is left of linear red, green and blue (Machado et al. 2009, whole loss of a kind of cone).
const kinds: Record<string, Triple[]> = {
  none: [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
  red: [
    [0.152286, 1.052583, -0.204868],
    [0.114503, 0.786281, 0.099216],
    [-0.003882, -0.048116, 1.051998],
  ],
  green: [
    [0.367322, 0.860646, -0.227968],
    [0.280085, 0.672501, 0.047413],
    [-0.01182, 0.04294, 0.968881],
  ],
  blue: [
    [1.255528, -0.076749, -0.178779],
    [-0.078411, 0.930809, 0.147602],
    [0.004733, 0.691367, 0.3039],
  ],
};
const toXyz: Triple[] = [
  [0.4124 / 0.9505, 0.3576 / 0.9505, 0.1805 / 0.9505],
  [0.2126, 0.7152, 0.0722],
  [0.0193 / 1.089, 0.1192 / 1.089, 0.9505 / 1.089],
];

const dot = (a: Triple, b: Triple) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const times = (rows: Triple[], vector: Triple) => rows.map((row) => dot(row, vector)) as Triple;
const linear = (value: number) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);

function lab(hex: string, kind: Triple[]): Triple {
  const rgb = [1, 3, 5].map((at) => linear(Number.parseInt(hex.slice(at, at + 2), 16) / 255)) as Triple;
  const seen = times(kind, rgb).map((value) => Math.min(1, Math.max(0, value))) as Triple;
  const [x, y, z] = times(toXyz, seen).map((v) => (v > 0.008856 ? Math.cbrt(v) : 7.787 * v + 16 / 116)) as Triple;
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

test('the colours of robots are told apart, also by who is colour-blind', () => {
  const style = readFileSync('src/app/base.css', 'utf8');
  const colours = [...style.matchAll(/--map-robot-\d: (#\w{6})/g)].map(([, hex]) => hex ?? '');
  assert.equal(colours.length, 12);
  for (const theme of [colours.slice(0, 6), colours.slice(6)])
    for (const [name, kind] of Object.entries(kinds))
      for (const [i, a] of theme.entries())
        for (const b of theme.slice(0, i)) {
          const [from, to] = [lab(a, kind), lab(b, kind)];
          const apart = Math.hypot(from[0] - to[0], from[1] - to[1], from[2] - to[2]);
          assert(apart > 25, `${a} and ${b} without ${name}: ${apart.toFixed(1)}`);
        }
});
