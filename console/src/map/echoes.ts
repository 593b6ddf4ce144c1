// The echoes of a scan: its valid points, unless others are wanted, without an object for each. Works for laser range
// finders, whose points are an angle and a distance, and for 2D scans, whose points have coordinates. Pure.

import type { Elements } from '../codec/views';

export const pointType = { invalid: 0x10, beyondRange: 0x20, reflector: 0x80, classMask: 0x03, moving: 3 };

// The segment that a point belongs to, in scans that have been cut into segments; else 0.
export function segmentOf({ i32, step4, index }: Elements, i: number): number {
  const { segment } = index as Record<string, number | undefined>;
  return segment === undefined ? 0 : (i32[i * step4 + segment] ?? 0);
}

const useless = pointType.invalid | pointType.beyondRange;

// x is forward, y to the right, in mm; i is the number of the point. `kind`: which of the two bits of useless points it has.
export function eachEcho(
  points: Elements,
  take: (x: number, y: number, type: number, i: number) => void,
  kind = 0,
): void {
  const { i32, f32, step4, length } = points;
  const { x, y, angle, distance, type: typeAt = 0 } = points.index as Record<string, number | undefined>;
  for (let i = 0; i < length; ++i) {
    const at = i * step4;
    const type = i32[at + typeAt] ?? 0;
    if ((type & useless) !== kind) continue;
    if (x !== undefined && y !== undefined) take(i32[at + x] ?? 0, i32[at + y] ?? 0, type, i);
    else if (angle !== undefined && distance !== undefined) {
      const range = i32[at + distance] ?? 0;
      const direction = f32[at + angle] ?? 0;
      take(range * Math.cos(direction), range * Math.sin(direction), type, i);
    }
  }
}

// How far the farthest valid point is, in mm; 0: there is none.
export function farthestEcho(points: Elements): number {
  const { i32, step4, length } = points;
  const { x, y: secondAt, distance = 0, type = 0 } = points.index as Record<string, number | undefined>;
  const firstAt = x ?? distance;
  let square = 0;
  for (let i = 0; i < length; ++i) {
    const at = i * step4;
    if (((i32[at + type] ?? 0) & useless) !== 0) continue;
    const first = i32[at + firstAt] ?? 0;
    const second = secondAt === undefined ? 0 : (i32[at + secondAt] ?? 0);
    square = Math.max(square, first * first + second * second);
  }
  return Math.sqrt(square);
}
