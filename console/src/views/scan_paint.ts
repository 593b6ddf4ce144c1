// Draws a scan, seen from above in the robot's frame: forward is up.

import { valueName } from '../codec/catalogue';
import type { Elements } from '../codec/views';
import { type MapColours, mapColours } from '../map/colours';
import { eachEcho, pointType, segmentOf } from '../map/echoes';
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
  let farthest = 1000;
  eachEcho(points, (x, y) => {
    farthest = Math.max(farthest, Math.hypot(x, y));
  });
  const rounded = 1000 * Math.SQRT2 ** Math.ceil(2 * Math.log2(farthest / 1000));
  return maxRange > 0 ? Math.min(rounded, maxRange) : rounded;
}

export function paintScan(canvas: HTMLCanvasElement, data: ScanData, sight: ScanLook, isLadar: boolean): void {
  const ratio = devicePixelRatio;
  const size: Size = { width: canvas.clientWidth, height: canvas.clientHeight };
  resize(canvas, Math.round(size.width * ratio), Math.round(size.height * ratio));
  const context = canvas.getContext('2d', { alpha: false });
  if (context === null || size.width === 0) return;
  const colours = mapColours();
  const view = scanView(data, sight, size);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.fillStyle = colours.ground;
  context.fillRect(0, 0, size.width, size.height);
  paintRings(context, view, size, colours);
  if (sight.style === 'lines') paintLines(context, data, view, size, colours.scan);
  else paintPoints(context, data, view, size, colourOf(colours, data, sight.style, isLadar), sight.style === 'far');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  paintRobot(context, view, size, colours);
}

type ColourOf = (type: number, i: number) => string;

function colourOf(colours: MapColours, { points }: ScanData, style: ScanStyle, isLadar: boolean): ColourOf {
  const { scan, reflector, moving, transparent, rain, dirt, robots } = colours;
  if (style === 'segments') return (_, i) => robots[segmentOf(points, i) % robots.length] ?? scan;
  const byName: Record<string, string> = { transparent, rain, dirt };
  return (type) => {
    if ((type & pointType.reflector) !== 0) return reflector;
    const kind = type & pointType.classMask;
    if (isLadar) return kind === 0 ? scan : (byName[valueName('LadarPoint.type', kind) ?? ''] ?? scan);
    return kind === pointType.moving ? moving : scan;
  };
}

// `grows`: points are as far apart as the beams are wide, so that a wall is closed at each distance.
function paintPoints(
  context: CanvasRenderingContext2D,
  data: ScanData,
  view: View,
  size: Size,
  colour: ColourOf,
  grows: boolean,
) {
  const ratio = devicePixelRatio;
  const least = Math.max(2, Math.round(Math.min(6, 2.5 * Math.sqrt(view.scale / wholeScale)) * ratio));
  context.setTransform(1, 0, 0, 1, 0, 0); // whole pixels of the screen: they need no smoothing
  eachEcho(data.points, (forward, right, type, i) => {
    const { x, y } = toScreen(view, size, { x: forward, y: right });
    const beam = grows ? Math.round(beamWidth * Math.hypot(forward, right) * view.scale * ratio) : 0;
    const width = Math.max(least, Math.min(beam, beamPixelsMax));
    context.fillStyle = colour(type, i);
    context.fillRect(Math.round(x * ratio - width / 2), Math.round(y * ratio - width / 2), width, width);
  });
}

const wholeScale = 0.03; // pixels a mm
const beamWidth = Math.PI / 360; // rad
const beamPixelsMax = 40;

function paintLines(context: CanvasRenderingContext2D, data: ScanData, view: View, size: Size, colour: string): void {
  context.strokeStyle = colour;
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

function paintRobot(context: CanvasRenderingContext2D, view: View, size: Size, colours: MapColours): void {
  const { x, y } = toScreen(view, size, { x: 0, y: 0 });
  context.fillStyle = colours.robots[0] ?? colours.text;
  context.beginPath();
  context.moveTo(x, y - 8);
  context.lineTo(x + 5, y + 6);
  context.lineTo(x - 5, y + 6);
  context.fill();
}

function paintRings(context: CanvasRenderingContext2D, view: View, size: Size, colours: MapColours): void {
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
