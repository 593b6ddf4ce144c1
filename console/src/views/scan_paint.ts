// Draws a scan, seen from above in the robot's frame: forward is up.

import { valueName } from '../codec/catalogue';
import type { Elements } from '../codec/views';
import { type MapColours, mapColours } from '../map/colours';
import { eachEcho, farthestEcho, pointType, segmentOf } from '../map/echoes';
import { PointBuffer, pixelOf } from '../map/points';
import { gridStep, type Point, type Size, toScreen, type View } from '../map/transform';
import { resize } from './parts';

export interface ScanData {
  maxRange: number;
  points: Elements;
}

export type ScanStyle = 'points' | 'far' | 'segments' | 'lines';

export interface ScanLook {
  style: ScanStyle;
  zoom: number; // 1: all echoes are in sight
  centre: Point; // mm
}

const ringPixels = 40;
const textHeight = 14; // pixels
const zoomMax = 50;

export const wholeScan: ScanLook = { style: 'points', zoom: 1, centre: { x: 0, y: 0 } };

export function zoomedScan(sight: ScanLook, factor: number): ScanLook {
  const zoom = Math.min(zoomMax, Math.max(1, sight.zoom * factor));
  return { ...sight, zoom, centre: zoom === 1 ? wholeScan.centre : sight.centre };
}

export function scanView(data: ScanData, { zoom, centre }: ScanLook, size: Size): View {
  return { centre, scale: (zoom * 0.48 * Math.min(size.width, size.height)) / rangeOf(data), up: 0 };
}

// The farthest echo decides the scale, in steps, so that the picture does not breathe.
function rangeOf({ points, maxRange }: ScanData): number {
  const rounded = 1000 * Math.SQRT2 ** Math.ceil(2 * Math.log2(Math.max(1, farthestEcho(points) / 1000)));
  return maxRange > 0 ? Math.min(rounded, maxRange) : rounded;
}

// The rings and the robot are painted when the view changes, the echoes above them for each scan.
export class ScanPainter {
  private readonly buffer = new PointBuffer();
  private ground = ''; // what it was painted for

  constructor(private readonly canvas: HTMLCanvasElement) {}

  // `size`: of the canvas, in CSS pixels.
  paint(data: ScanData, sight: ScanLook, size: Size, isLadar: boolean): void {
    const context = this.canvas.getContext('2d', { alpha: false, willReadFrequently: true });
    if (context === null || size.width === 0) return;
    const ratio = devicePixelRatio;
    const surface = { context, size, ratio, view: scanView(data, sight, size), colours: mapColours() };
    this.keepGround(surface);
    this.buffer.clear();
    if (sight.style !== 'lines') {
      const colour = colourOf(surface.colours, data, sight.style, isLadar);
      addPoints(this.buffer, data, surface, colour, { grows: sight.style === 'far', isLadar });
    }
    this.buffer.replace(context);
    if (sight.style === 'lines') paintLines(data, surface);
  }

  private keepGround(surface: Surface): void {
    const { context, size, ratio, view, colours } = surface;
    const ground = JSON.stringify([size, ratio, view, colours.ground]);
    if (ground === this.ground) return;
    this.ground = ground;
    const [width, height] = [Math.round(size.width * ratio), Math.round(size.height * ratio)];
    resize(this.canvas, width, height);
    this.buffer.resize(width, height);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = colours.ground;
    context.fillRect(0, 0, width, height); // the size of the view may be no whole number of pixels
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    paintRings(surface);
    paintRobot(surface);
    this.buffer.keepGround(context);
  }
}

interface Surface {
  context: CanvasRenderingContext2D;
  size: Size;
  ratio: number; // device pixels a CSS pixel
  view: View;
  colours: MapColours;
}

type ColourOf = (type: number, i: number) => number;

function colourOf(colours: MapColours, { points }: ScanData, style: ScanStyle, isLadar: boolean): ColourOf {
  const [scan, reflector, moving] = [pixelOf(colours.scan), pixelOf(colours.reflector), pixelOf(colours.moving)];
  if (style === 'segments') {
    const robots = colours.robots.map(pixelOf);
    return (_, i) => robots[segmentOf(points, i) % robots.length] ?? scan;
  }
  const { transparent, rain, dirt } = colours;
  const invalid = pixelOf(colours.stale);
  const byName: Record<string, string> = { transparent, rain, dirt };
  const byKind = Array.from({ length: pointType.classMask + 1 }, (_, kind) =>
    kind === 0 ? scan : pixelOf(byName[valueName('LadarPoint.type', kind) ?? ''] ?? colours.scan),
  );
  return (type) => {
    if ((type & pointType.invalid) !== 0) return invalid;
    if ((type & pointType.reflector) !== 0) return reflector;
    const kind = type & pointType.classMask;
    if (isLadar) return byKind[kind] ?? scan;
    return kind === pointType.moving ? moving : scan;
  };
}

interface PointStyle {
  grows: boolean; // points are as far apart as the beams are wide, so that a wall is closed at each distance
  isLadar: boolean; // invalid points are shown, too: they tell what the device does not see well
}

function addPoints(
  buffer: PointBuffer,
  data: ScanData,
  { view, size, ratio }: Surface,
  colour: ColourOf,
  { grows, isLadar }: PointStyle,
): void {
  const least = Math.max(2, Math.round(Math.min(6, 2.5 * Math.sqrt(view.scale / wholeScale)) * ratio));
  const robot = toScreen(view, size, { x: 0, y: 0 });
  const add = (forward: number, right: number, type: number, i: number) => {
    const x = robot.x + right * view.scale; // forward is up
    const y = robot.y - forward * view.scale;
    const beam = grows ? Math.round(beamWidth * Math.hypot(forward, right) * view.scale * ratio) : 0;
    buffer.add(x * ratio, y * ratio, colour(type, i), Math.max(least, Math.min(beam, beamPixelsMax)));
  };
  // Below the valid ones.
  if (isLadar)
    eachEcho(
      data.points,
      (forward, right, type, i) => {
        if (forward !== 0 || right !== 0) add(forward, right, type, i);
      },
      pointType.invalid,
    );
  eachEcho(data.points, add);
}

const wholeScale = 0.03; // pixels a mm
const beamWidth = Math.PI / 360; // rad
const beamPixelsMax = 40;

function paintLines(data: ScanData, { context, size, view, colours }: Surface): void {
  context.strokeStyle = colours.scan;
  context.lineWidth = 1.5;
  context.beginPath();
  let before: number | undefined;
  eachEcho(data.points, (forward, right, _, i) => {
    const { x, y } = toScreen(view, size, { x: forward, y: right });
    if (before === i - 1) context.lineTo(x, y);
    else context.moveTo(x, y);
    before = i;
  });
  context.stroke();
}

function paintRobot({ context, size, view, colours }: Surface): void {
  const { x, y } = toScreen(view, size, { x: 0, y: 0 });
  context.fillStyle = colours.robots[0] ?? colours.text;
  context.beginPath();
  context.moveTo(x, y - 8);
  context.lineTo(x + 5, y + 6);
  context.lineTo(x - 5, y + 6);
  context.fill();
}

function paintRings({ context, size, view, colours }: Surface): void {
  const step = gridStep(view.scale, ringPixels);
  const { x, y } = toScreen(view, size, { x: 0, y: 0 });
  context.strokeStyle = colours.grid;
  context.fillStyle = colours.text;
  context.font = '11px system-ui, sans-serif';
  context.lineWidth = 1;
  const most =
    (Math.hypot(x - size.width / 2, y - size.height / 2) + Math.hypot(size.width, size.height) / 2) / view.scale;
  for (let radius = step; radius < most; radius += step) {
    context.beginPath();
    context.arc(x, y, radius * view.scale, 0, 2 * Math.PI);
    context.stroke();
    const top = y - radius * view.scale;
    if (top > textHeight) context.fillText(`${radius / 1000} m`, x + 3, top - 3);
  }
}
