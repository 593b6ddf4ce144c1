// From the world to the screen. The world's x points north (up), y east (right), in mm; headings are clockwise from
// north, in rad. The screen's unit is the CSS pixel.

export interface Point {
  x: number;
  y: number;
}

export interface Pose extends Point {
  rho: number;
}

export interface View {
  centre: Point; // world
  scale: number; // pixels a mm
  up: number; // the heading that points up
}

export interface Size {
  width: number;
  height: number;
}

const scaleMin = 1e-5;
const scaleMax = 2;

export function toScreen(view: View, size: Size, { x, y }: Point): Point {
  const north = x - view.centre.x;
  const east = y - view.centre.y;
  const cos = Math.cos(view.up);
  const sin = Math.sin(view.up);
  return {
    x: size.width / 2 + (east * cos - north * sin) * view.scale,
    y: size.height / 2 - (north * cos + east * sin) * view.scale,
  };
}

export function toWorld(view: View, size: Size, { x, y }: Point): Point {
  const right = (x - size.width / 2) / view.scale;
  const up = (size.height / 2 - y) / view.scale;
  const cos = Math.cos(view.up);
  const sin = Math.sin(view.up);
  return { x: view.centre.x + up * cos - right * sin, y: view.centre.y + right * cos + up * sin };
}

// A point of a robot's frame (x forward, y to the right) in the world.
export function placed(pose: Pose, { x, y }: Point): Point {
  const cos = Math.cos(pose.rho);
  const sin = Math.sin(pose.rho);
  return { x: pose.x + x * cos - y * sin, y: pose.y + x * sin + y * cos };
}

// The point below the pointer stays there.
export function zoomed(view: View, size: Size, at: Point, factor: number): View {
  const scale = Math.min(scaleMax, Math.max(scaleMin, view.scale * factor));
  const before = toWorld(view, size, at);
  const after = toWorld({ ...view, scale }, size, at);
  return { ...view, scale, centre: { x: view.centre.x + before.x - after.x, y: view.centre.y + before.y - after.y } };
}

export function panned(view: View, right: number, down: number): View {
  const origin = toWorld(view, { width: 0, height: 0 }, { x: 0, y: 0 });
  const moved = toWorld(view, { width: 0, height: 0 }, { x: right, y: down });
  return { ...view, centre: { x: view.centre.x + origin.x - moved.x, y: view.centre.y + origin.y - moved.y } };
}

// A view that shows all of these points, with a margin.
export function viewOf(points: Point[], size: Size): View | undefined {
  if (points.length === 0) return undefined;
  const xs = points.map(({ x }) => x);
  const ys = points.map(({ y }) => y);
  const [north, south, east, west] = [Math.max(...xs), Math.min(...xs), Math.max(...ys), Math.min(...ys)];
  const extent = (pixels: number, length: number) => (0.85 * pixels) / Math.max(length, 4000);
  return {
    centre: { x: (north + south) / 2, y: (east + west) / 2 },
    scale: Math.min(extent(size.height, north - south), extent(size.width, east - west)),
    up: 0,
  };
}

// The distance between two grid lines, in mm: 1, 2 or 5 times a power of ten, at least this many pixels.
export function gridStep(scale: number, pixels: number): number {
  const least = pixels / scale;
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= least) ?? 10 * power;
}

// In -pi to pi.
export function headingTo(from: Point, to: Point): number {
  return Math.atan2(to.y - from.y, to.x - from.x);
}

export function distanceToLine(at: Point, from: Point, to: Point): number {
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  const square = dx * dx + dy * dy;
  const part = square === 0 ? 0 : ((at.x - from.x) * dx + (at.y - from.y) * dy) / square;
  const along = Math.min(1, Math.max(0, part));
  return Math.hypot(from.x + along * dx - at.x, from.y + along * dy - at.y);
}
