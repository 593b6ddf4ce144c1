// Data that are pictures: the cells of a grid map, and the ranges of a scan of space.

import { useSignal } from '@preact/signals';
import { useMemo } from 'preact/hooks';
import { useConsole } from '../app/console';
import { decodeStruct, valueName } from '../codec/catalogue';
import type { GridMapData, Scan3dRangeImageData } from '../codec/messages';
import { opaque } from '../map/points';
import { command } from '../model/commands';
import { CheckBox } from '../ui/check_box';
import { metres } from '../ui/quantities';
import { useAsked, useStream } from '../ui/use_stream';
import type { Pixel } from './colour_tables';
import { Values } from './parts';
import { Picture } from './picture';
import { StreamBox, type ViewProperties } from './view';

const slow = 1000; // ms
const unknownCell = 127;

export function GridMapView({ component }: ViewProperties) {
  const stream = useStream<GridMapData>(component.address, slow);
  const data = stream.value.value?.data;
  const pixels = useMemo(() => (data === undefined ? undefined : cellsOf(data)), [data]);
  return (
    <StreamBox component={component} stream={stream}>
      <Picture pixels={pixels} label="Grid map, north is up" name="grid-map" sharp />
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
    </StreamBox>
  );
}

// x is up, y is to the right; occupied is dark.
function cellsOf({ gridNumX: rows, gridNumY: columns, occupancy }: GridMapData): ImageData | undefined {
  return pictureOf(columns, rows, (column, row) => {
    const value = occupancy[rows - 1 - row + column * rows] ?? unknownCell;
    return [255 - value, 255 - value, 255 - value];
  });
}

// The scan itself may have hundreds of thousands of points, which would be sent and decoded for nothing: what is shown is
// its range image.
export function Scan3dView({ component }: ViewProperties) {
  const { client } = useConsole();
  const stream = useAsked(component, slow, async () => {
    const answer = await command(client, component, 'Scan3d.GET_RANGE_IMAGE');
    return decodeStruct('Scan3dRangeImageData', answer.body, answer.flags);
  });
  const far = useSignal(10);
  const byType = useSignal(false);
  const hexagonal = useSignal(false);
  const image = stream.value.value?.data;
  const pixels = useMemo(
    () =>
      image === undefined
        ? undefined
        : rangesOf(image, { far: far.value * 1000, byType: byType.value, hexagonal: hexagonal.value }),
    [image, far.value, byType.value, hexagonal.value],
  );
  return (
    <StreamBox component={component} stream={stream}>
      <Picture pixels={pixels} label="Range image: near is red, far is blue" name="range-image" sharp />
      <CheckBox checked={byType}>Colours by kind</CheckBox>
      <CheckBox checked={hexagonal}>Every second scan lies half a point lower</CheckBox>
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
      {image !== undefined && (
        <Values
          of={{
            mounting: valueName('Scan3dData.scanMode', image.scanMode) ?? `${image.scanMode}`,
            scans: `${image.scanNum}`,
            'points a scan': `${image.scanPointNum}`,
            range: metres(image.maxRange),
          }}
        />
      )}
    </StreamBox>
  );
}

const kinds: Pixel[] = [
  [200, 200, 200],
  [230, 90, 70],
  [70, 140, 230],
  [80, 190, 110],
  [230, 180, 60],
  [170, 90, 200],
];

interface RangeStyle {
  far: number; // mm
  byType: boolean;
  hexagonal: boolean;
}

// Of a hexagonal grid each point is two pixels, so that half of one can be shown.
function rangesOf({ scanNum, scanPointNum: rows, points }: Scan3dRangeImageData, style: RangeStyle) {
  const { far, byType, hexagonal } = style;
  const scale = hexagonal ? 2 : 1;
  return pictureOf(scanNum * scale, rows * scale + (hexagonal ? 1 : 0), (right, down) => {
    const column = Math.floor(right / scale);
    const row = Math.floor((down - (hexagonal ? column % 2 : 0)) / scale);
    if (row < 0 || row >= rows) return [0, 0, 0];
    const { range, type } = points[column * rows + (rows - 1 - row)] ?? { range: 0, type: 0 };
    if (byType && range > 0) return kinds[Math.abs(type) % kinds.length] ?? heat(1);
    return range <= 0 ? [0, 0, 0] : heat(Math.min(1, range / far));
  });
}

// From red (0) over yellow and green to blue (1).
function heat(part: number): Pixel {
  const ramp = (centre: number) => Math.round(255 * Math.max(0, Math.min(1, 1.5 - Math.abs(4 * part - centre))));
  return [Math.min(255, ramp(0.5) + ramp(-0.5)), ramp(2), Math.min(255, ramp(3.5) + ramp(4.5))];
}

function pictureOf(
  width: number,
  height: number,
  colour: (column: number, row: number) => Pixel,
): ImageData | undefined {
  if (width <= 0 || height <= 0) return undefined;
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  for (let row = 0; row < height; ++row)
    for (let column = 0; column < width; ++column) pixels[row * width + column] = opaque(...colour(column, row));
  return image;
}
