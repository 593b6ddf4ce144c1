// The echoes of a scan: its points, those that are valid unless more are wanted, without an object for each. Works for laser range finders, whose points are
// an angle and a distance, and for 2D scans, whose points have coordinates. Pure.

import type { Elements } from '../codec/views';

export const pointType = { invalid: 0x10, beyondRange: 0x20, reflector: 0x80, classMask: 0x03, moving: 3 };

// The segment that a point belongs to, in scans that have been cut into segments; else 0.
export function segmentOf({ i32, step4, index }: Elements, i: number): number {
  const { segment } = index as Record<string, number | undefined>;
  return segment === undefined ? 0 : (i32[i * step4 + segment] ?? 0);
}

const useless = pointType.invalid | pointType.beyondRange;

// x is forward, y to the right, in mm; i is the number of the point. `left`: the kinds of points that are left out.
export function eachEcho(
  points: Elements,
  take: (x: number, y: number, type: number, i: number) => void,
  left = useless,
): void {
  const { i32, f32, step4, length } = points;
  const { x, y, angle, distance, type = 0 } = points.index as Record<string, number | undefined>;
  for (let i = 0; i < length; ++i) {
    const at = i * step4;
    const kind = i32[at + type] ?? 0;
    if ((kind & left) !== 0) continue;
    if (x !== undefined && y !== undefined) take(i32[at + x] ?? 0, i32[at + y] ?? 0, kind, i);
    else if (angle !== undefined && distance !== undefined) {
      const range = i32[at + distance] ?? 0;
      const direction = f32[at + angle] ?? 0;
      take(range * Math.cos(direction), range * Math.sin(direction), kind, i);
    }
  }
}
