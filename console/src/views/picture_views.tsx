// Data that are pictures: the cells of a grid map, and the ranges of a scan of space.

import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { useConsole } from '../app/console';
import { decodeStruct } from '../codec/catalogue';
import type { GridMapData, Scan3dData, Scan3dRangeImageData } from '../codec/messages';
import { command } from '../model/commands';
import { useAttempt } from '../ui/attempt';
import { saveCanvas } from '../ui/save';
import { useStream } from '../ui/use_stream';
import { Values } from './parts';
import { StreamBox, type ViewProperties } from './view';

const slow = 1000; // ms
const unknownCell = 127;

export function GridMapView({ component }: ViewProperties) {
  const stream = useStream<GridMapData>(component.address, slow);
  const canvas = useRef<HTMLCanvasElement>(null);
  const data = stream.value.value?.data;
  useEffect(() => {
    if (data === undefined || canvas.current === null) return;
    // x is up, y is to the right; occupied is dark.
    const { gridNumX: rows, gridNumY: columns, occupancy } = data;
    paint(canvas.current, columns, rows, (column, row) => {
      const value = occupancy[rows - 1 - row + column * rows] ?? unknownCell;
      return [255 - value, 255 - value, 255 - value];
    });
  }, [data]);
  return (
    <StreamBox component={component} stream={stream}>
      <canvas ref={canvas} class="picture pixels" role="img" aria-label="Grid map, north is up" />
      {data !== undefined && (
        <Values
          of={{
            cells: `${data.gridNumX} × ${data.gridNumY}`,
            'of a cell': `${data.scale} mm`,
            'corner north': `${(data.offsetX / 1000).toFixed(2)} m`,
            'corner east': `${(data.offsetY / 1000).toFixed(2)} m`,
          }}
        />
      )}
      <SaveButton canvas={canvas} name="grid-map.png" />
    </StreamBox>
  );
}

// The scan itself may have hundreds of thousands of points: what is shown is its range image, asked for once for each.
export function Scan3dView({ component }: ViewProperties) {
  const { client } = useConsole();
  const stream = useStream<Scan3dData>(component.address, slow);
  const canvas = useRef<HTMLCanvasElement>(null);
  const far = useSignal(10);
  const { attempt, Failure } = useAttempt();
  const value = stream.value.value;
  useEffect(() => {
    if (value === undefined) return;
    attempt(async () => {
      const answer = await command(client, component, 'Scan3d.GET_RANGE_IMAGE');
      const image = decodeStruct('Scan3dRangeImageData', answer.body, answer.flags);
      if (canvas.current !== null) paintRanges(canvas.current, image, far.value * 1000);
    });
  }, [value, far.value]);
  return (
    <StreamBox component={component} stream={stream}>
      <canvas ref={canvas} class="picture pixels" role="img" aria-label="Range image: near is red, far is blue" />
      <label>
        Up to {far.value} m{' '}
        <input
          type="range"
          min="1"
          max="100"
          value={far.value}
          onInput={(event) => {
            far.value = Number(event.currentTarget.value);
          }}
        />
      </label>
      {value !== undefined && (
        <Values
          of={{
            scans: `${value.data.scanNum}`,
            'points a scan': `${value.data.scanPointNum}`,
            points: `${value.data.pointNum ?? value.data.points.length}`,
            duration: `${value.data.duration} ms`,
          }}
        />
      )}
      <SaveButton canvas={canvas} name="range-image.png" />
      <Failure />
    </StreamBox>
  );
}

function paintRanges(canvas: HTMLCanvasElement, image: Scan3dRangeImageData, far: number): void {
  const { scanNum: columns, scanPointNum: rows, points } = image;
  paint(canvas, columns, rows, (column, row) => {
    const range = points[column * rows + (rows - 1 - row)]?.range ?? 0;
    return range <= 0 ? [0, 0, 0] : heat(Math.min(1, range / far));
  });
}

// From red (0) over yellow and green to blue (1).
function heat(part: number): [number, number, number] {
  const ramp = (centre: number) => 255 * Math.max(0, Math.min(1, 1.5 - Math.abs(4 * part - centre)));
  return [ramp(0.5) + ramp(-0.5), ramp(2), ramp(3.5) + ramp(4.5)];
}

type Colour = (column: number, row: number) => [number, number, number];

function paint(canvas: HTMLCanvasElement, width: number, height: number, colour: Colour): void {
  if (width <= 0 || height <= 0) return;
  canvas.width = width;
  canvas.height = height;
  const image = new ImageData(width, height);
  for (let row = 0; row < height; ++row)
    for (let column = 0; column < width; ++column) {
      const [red, green, blue] = colour(column, row);
      image.data.set([red, green, blue, 255], 4 * (row * width + column));
    }
  canvas.getContext('2d')?.putImageData(image, 0, 0);
}

function SaveButton({ canvas, name }: { canvas: { current: HTMLCanvasElement | null }; name: string }) {
  return (
    <p class="actions">
      <button type="button" onClick={() => canvas.current !== null && saveCanvas(canvas.current, name)}>
        Save picture
      </button>
    </p>
  );
}
