// A scan with what one does to look at it.

import { effect, type ReadonlySignal, type Signal, useSignal, useSignalEffect } from '@preact/signals';
import type { RefObject } from 'preact';
import { useEffect, useRef } from 'preact/hooks';
import { classId } from '../codec/catalogue';
import { eachEcho } from '../map/echoes';
import { panned, type Size } from '../map/transform';
import type { Component } from '../model/fleet';
import { CheckBox } from '../ui/check_box';
import { useNow } from '../ui/connection';
import { metres } from '../ui/quantities';
import { saveFile } from '../ui/save';
import { isDark } from '../ui/theme';
import { defaultPeriod, eachSample, type Stream, useStream } from '../ui/use_stream';
import {
  type ScanData,
  type ScanLook,
  ScanPainter,
  type ScanStyle,
  scanView,
  wholeScan,
  zoomedScan,
} from './scan_paint';
import { StreamBox, type ViewProperties } from './view';

const options = { elements: true };
const zoomStep = 1.5;

type ScanStream = Stream<ScanData>;

function useScan(component: Component, period: number) {
  const stream = useStream<ScanData>(component.address, period, options);
  const sight = useSignal(wholeScan);
  return { stream, sight };
}

// For pages that show the scan beside other things.
export function ScanSight({ component }: ViewProperties) {
  const { stream, sight } = useScan(component, defaultPeriod);
  return (
    <StreamBox component={component} stream={stream}>
      <ScanCanvas component={component} stream={stream} sight={sight} />
      <ScanFacts stream={stream} />
    </StreamBox>
  );
}

export function ScanView({ component }: ViewProperties) {
  const isFull = useSignal(false);
  const { stream, sight } = useScan(component, isFull.value ? eachSample : defaultPeriod);
  const keeps = useSignal(false);
  useSignalEffect(() => {
    const value = stream.value.value;
    if (keeps.value && value !== undefined) saveScan(value.data);
  });
  const zoom = (factor: number) => {
    sight.value = zoomedScan(sight.value, factor);
  };
  return (
    <StreamBox component={component} stream={stream}>
      <ScanCanvas component={component} stream={stream} sight={sight} zoom={zoom} />
      <ScanFacts stream={stream} countsSkipped />
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
        <CheckBox checked={isFull}>full rate</CheckBox>
        <button
          type="button"
          onClick={() => {
            const value = stream.value.peek();
            if (value !== undefined) saveScan(value.data);
          }}
        >
          Save points
        </button>
        <CheckBox checked={keeps}>save each</CheckBox>
      </p>
    </StreamBox>
  );
}

interface ScanCanvasProperties extends ViewProperties {
  stream: ScanStream;
  sight: Signal<ScanLook>;
  zoom?: (factor: number) => void; // by the wheel
}

// Draws when a sample comes, without a new look at the elements around it.
function ScanCanvas({ component, stream, sight, zoom }: ScanCanvasProperties) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const size = useSize(canvas);
  const isLadar = component.classId === classId('Ladar');
  useEffect(() => {
    if (canvas.current === null) return;
    const painter = new ScanPainter(canvas.current);
    return effect(() => {
      isDark(); // in other colours
      const value = stream.value.value;
      if (value !== undefined) painter.paint(value.data, sight.value, size.value, isLadar);
    });
  }, [stream.value, isLadar]);
  const drag = ({
    buttons,
    movementX,
    movementY,
    currentTarget,
  }: PointerEvent & { currentTarget: HTMLCanvasElement }) => {
    const value = stream.value.peek();
    if (buttons === 0 || value === undefined || sight.value.zoom === 1) return;
    const size = { width: currentTarget.clientWidth, height: currentTarget.clientHeight };
    const { centre } = panned(scanView(value.data, sight.value, size), movementX, movementY);
    sight.value = { ...sight.value, centre };
  };
  const turnWheel = (event: WheelEvent) => {
    if (zoom === undefined || (!event.ctrlKey && sight.value.zoom === 1 && event.deltaY > 0)) return; // the page scrolls
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 400));
  };
  return (
    <canvas
      ref={canvas}
      class={`scan ${sight.value.zoom > 1 ? 'enlarged' : ''}`}
      role="img"
      aria-label="Scan, forward is up"
      onPointerMove={drag}
      onWheel={turnWheel}
    />
  );
}

// Of an element, in CSS pixels. To ask for it at each sample would lay out the page as often.
function useSize(element: RefObject<Element | null>): ReadonlySignal<Size> {
  const size = useSignal<Size>({ width: 0, height: 0 });
  useEffect(() => {
    if (element.current === null) return;
    const observer = new ResizeObserver(([entry]) => {
      if (entry !== undefined) size.value = { width: entry.contentRect.width, height: entry.contentRect.height };
    });
    observer.observe(element.current);
    return () => observer.disconnect();
  }, []);
  return size;
}

// Twice a second: who reads cannot follow faster.
function ScanFacts({ stream, countsSkipped = false }: { stream: ScanStream; countsSkipped?: boolean }) {
  useNow(500);
  const value = stream.value.peek();
  if (value === undefined) return null;
  const { data, skipped, received } = value;
  const near = nearest(data);
  return (
    <p class="small faint">
      {data.points.length} points; the nearest is {near === undefined ? 'not there' : `${metres(near)} away`}
      {countsSkipped && skipped > 0 && `; ${skipped} of ${received} scans were not drawn`}
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
