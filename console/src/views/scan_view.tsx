// A scan with what one does to look at it.

import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { classId } from '../codec/catalogue';
import { eachEcho } from '../map/echoes';
import { panned } from '../map/transform';
import { CheckBox } from '../ui/check_box';
import { metres } from '../ui/quantities';
import { saveFile } from '../ui/save';
import { isDark } from '../ui/theme';
import { defaultPeriod, useStream } from '../ui/use_stream';
import { paintScan, type ScanData, type ScanStyle, scanView, wholeScan, zoomedScan } from './scan_paint';
import { StreamBox, type ViewProperties } from './view';

const options = { elements: true };
const zoomStep = 1.5;

function useScan({ component }: ViewProperties) {
  const stream = useStream<ScanData>(component.address, defaultPeriod, options);
  const canvas = useRef<HTMLCanvasElement>(null);
  const sight = useSignal(wholeScan);
  const value = stream.value.value;
  const dark = isDark();
  const isLadar = component.classId === classId('Ladar');
  useEffect(() => {
    if (canvas.current !== null && value !== undefined) paintScan(canvas.current, value.data, sight.value, isLadar);
  }, [value, dark, sight.value]);
  return { stream, canvas, sight, value };
}

// For pages that show the scan beside other things.
export function ScanSight({ component }: ViewProperties) {
  const { stream, canvas, value } = useScan({ component });
  const near = value === undefined ? undefined : nearest(value.data);
  return (
    <StreamBox component={component} stream={stream}>
      <canvas ref={canvas} class="scan" role="img" aria-label="Scan, forward is up" />
      {value !== undefined && <ScanFacts points={value.data.points.length} near={near} skipped="" />}
    </StreamBox>
  );
}

export function ScanView({ component }: ViewProperties) {
  const { stream, canvas, sight, value } = useScan({ component });
  const keeps = useSignal(false);
  useEffect(() => {
    if (keeps.value && value !== undefined) saveScan(value.data);
  }, [value]);
  const zoom = (factor: number) => {
    sight.value = zoomedScan(sight.value, factor);
  };
  const drag = (event: PointerEvent) => {
    if (event.buttons === 0 || value === undefined || canvas.current === null || sight.value.zoom === 1) return;
    const size = { width: canvas.current.clientWidth, height: canvas.current.clientHeight };
    const { centre } = panned(scanView(value.data, sight.value, size), event.movementX, event.movementY);
    sight.value = { ...sight.value, centre };
  };
  const skipped = (value?.skipped ?? 0) > 0 ? `; ${value?.skipped} of ${value?.received} scans were not drawn` : '';
  return (
    <StreamBox component={component} stream={stream}>
      <canvas
        ref={canvas}
        class={`scan ${sight.value.zoom > 1 ? 'enlarged' : ''}`}
        role="img"
        aria-label="Scan, forward is up"
        onPointerMove={drag}
        onWheel={(event) => {
          if (!event.ctrlKey && sight.value.zoom === 1 && event.deltaY > 0) return; // the page scrolls
          event.preventDefault();
          zoom(Math.exp(-event.deltaY / 400));
        }}
      />
      {value !== undefined && (
        <ScanFacts points={value.data.points.length} near={nearest(value.data)} skipped={skipped} />
      )}
      <p class="actions">
        <button type="button" aria-label="Enlarge the scan" onClick={() => zoom(zoomStep)}>
          +
        </button>
        <button type="button" aria-label="Make the scan smaller" onClick={() => zoom(1 / zoomStep)}>
          −
        </button>
        <select
          aria-label="Show the scan as"
          value={sight.value.style}
          onChange={(event) => {
            sight.value = { ...sight.value, style: event.currentTarget.value as ScanStyle };
          }}
        >
          <option value="points">points by kind</option>
          <option value="far">points that grow with distance</option>
          <option value="segments">points by segment</option>
          <option value="lines">lines</option>
        </select>
        <button type="button" onClick={() => value !== undefined && saveScan(value.data)}>
          Save points
        </button>
        <CheckBox checked={keeps}>save each</CheckBox>
      </p>
    </StreamBox>
  );
}

function ScanFacts({ points, near, skipped }: { points: number; near: number | undefined; skipped: string }) {
  return (
    <p class="small faint">
      {points} points; the nearest is {near === undefined ? 'not there' : metres(near)} away{skipped}
    </p>
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

function saveScan({ points }: ScanData): void {
  const lines = ['x_mm,y_mm,type\n'];
  eachEcho(points, (x, y, type) => lines.push(`${Math.round(x)},${Math.round(y)},${type}\n`));
  saveFile(lines, 'text/csv', `scan-${Date.now()}.csv`);
}
