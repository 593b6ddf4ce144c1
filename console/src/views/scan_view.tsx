// A scan, seen from above in the robot's frame: forward is up.

import { useEffect, useRef } from 'preact/hooks';
import type { Elements } from '../codec/views';
import { mapColours } from '../map/colours';
import { eachEcho, pointType } from '../map/echoes';
import { PointBuffer, pixelOf } from '../map/points';
import { gridStep, type Size, toScreen, type View } from '../map/transform';
import { metres } from '../ui/quantities';
import { isDark } from '../ui/theme';
import { defaultPeriod, useStream } from '../ui/use_stream';
import { StreamBox, type ViewProperties } from './view';

interface ScanData {
  maxRange: number;
  points: Elements;
}

const options = { elements: true };
const ringPixels = 40;

export function ScanView({ component }: ViewProperties) {
  const stream = useStream<ScanData>(component.address, defaultPeriod, options);
  const canvas = useRef<HTMLCanvasElement>(null);
  const value = stream.value.value;
  const dark = isDark();
  useEffect(() => {
    if (canvas.current !== null && value !== undefined) paint(canvas.current, value.data);
  }, [value, dark]);
  const near = value === undefined ? undefined : nearest(value.data);
  return (
    <StreamBox component={component} stream={stream}>
      <canvas ref={canvas} class="scan" role="img" aria-label="Scan, forward is up" />
      {value !== undefined && (
        <p class="small faint">
          {value.data.points.length} points; the nearest is {near === undefined ? 'not there' : metres(near)} away
          {value.skipped > 0 && `; ${value.skipped} of ${value.received} scans were not drawn`}
        </p>
      )}
    </StreamBox>
  );
}

function nearest({ points }: ScanData): number | undefined {
  let least = Number.POSITIVE_INFINITY;
  eachEcho(points, (x, y) => {
    const distance = Math.hypot(x, y);
    if (distance > 0) least = Math.min(least, distance);
  });
  return Number.isFinite(least) ? least : undefined;
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

function paint(canvas: HTMLCanvasElement, data: ScanData): void {
  const ratio = devicePixelRatio;
  const size: Size = { width: canvas.clientWidth, height: canvas.clientHeight };
  canvas.width = Math.round(size.width * ratio);
  canvas.height = Math.round(size.height * ratio);
  const context = canvas.getContext('2d', { alpha: false });
  if (context === null || size.width === 0) return;
  const colours = mapColours(canvas);
  const scale = (0.48 * Math.min(size.width, size.height)) / rangeOf(data);
  const view: View = { centre: { x: 0, y: 0 }, scale, up: 0 };
  context.fillStyle = colours.ground;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  paintRings(context, view, size, colours.grid, colours.text);
  const points = new PointBuffer();
  points.resize(canvas.width, canvas.height);
  const plain = pixelOf(colours.scan);
  const bright = pixelOf(colours.reflector);
  eachEcho(data.points, (forward, right, type) => {
    const { x, y } = toScreen(view, size, { x: forward, y: right });
    points.add(x * ratio, y * ratio, (type & pointType.reflector) !== 0 ? bright : plain, Math.round(2.5 * ratio));
  });
  context.setTransform(1, 0, 0, 1, 0, 0);
  points.paint(context);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.fillStyle = colours.robots[0] ?? colours.text;
  context.beginPath();
  context.moveTo(size.width / 2, size.height / 2 - 8);
  context.lineTo(size.width / 2 + 5, size.height / 2 + 6);
  context.lineTo(size.width / 2 - 5, size.height / 2 + 6);
  context.fill();
}

function paintRings(context: CanvasRenderingContext2D, view: View, size: Size, line: string, text: string): void {
  const step = gridStep(view.scale, ringPixels);
  context.strokeStyle = line;
  context.fillStyle = text;
  context.font = '11px system-ui, sans-serif';
  context.lineWidth = 1;
  const most = Math.hypot(size.width, size.height) / 2 / view.scale;
  for (let radius = step; radius < most; radius += step) {
    context.beginPath();
    context.arc(size.width / 2, size.height / 2, radius * view.scale, 0, 2 * Math.PI);
    context.stroke();
    context.fillText(`${radius / 1000} m`, size.width / 2 + 3, size.height / 2 - radius * view.scale - 3);
  }
}
