// A picture with what one does to look at it: zoom, turn, the value of a pixel, and files.

import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { CheckBox } from '../ui/check_box';
import { saveCanvas } from '../ui/save';
import { matrixOf, type Orientation, orientations, pixelAt, turnedSize } from './orientation';
import { resize } from './parts';

export type Pixels = ImageData | ImageBitmap;

// Drawn around a part of the picture.
export interface Mark {
  x: number;
  y: number;
  width: number;
  height: number;
  text: string;
}

interface Properties {
  pixels: Pixels | undefined;
  label: string;
  name: string; // of its files
  sharp?: boolean; // its pixels are cells, and stay so when it is enlarged
  note?: string;
  plain?: boolean; // without its controls
  marks?: Mark[];
}

const zooms = [25, 50, 100, 200, 300, 400]; // %
const asIs = 'not turned';

export function Picture({ pixels, label, name, sharp = false, note = '', plain = false, marks = noMarks }: Properties) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const zoom = useSignal(0); // 0: as wide as its place
  const turn = useSignal(asIs);
  const keeps = useSignal(false);
  const pixel = useSignal('');
  const kept = useRef<Pixels | undefined>(undefined); // the last one that was saved
  const orientation = orientations[turn.value] as Orientation;
  useEffect(() => {
    if (canvas.current === null || pixels === undefined) return;
    draw(canvas.current, pixels, orientation);
    drawMarks(canvas.current, pixels, orientation, marks);
    if (!keeps.value || kept.current === pixels) return; // drawn anew with other marks, it is the same picture
    kept.current = pixels;
    saveCanvas(canvas.current, `${name}-${Date.now()}.png`);
  }, [pixels, orientation, marks]);
  const showPixel = ({ offsetX, offsetY, currentTarget }: MouseEvent & { currentTarget: HTMLCanvasElement }) => {
    if (pixels === undefined) return;
    const x = Math.floor((offsetX * currentTarget.width) / currentTarget.clientWidth);
    const y = Math.floor((offsetY * currentTarget.height) / currentTarget.clientHeight);
    const [red, green, blue] = currentTarget.getContext('2d')?.getImageData(x, y, 1, 1).data ?? [];
    const [column, row] = pixelAt(orientation, pixels, x, y);
    pixel.value = `; pixel ${column}, ${row}: ${red} ${green} ${blue}`;
  };
  const width =
    zoom.value === 0 ? undefined : `${(turnedSize(pixels ?? none, orientation).width * zoom.value) / 100}px`;
  const box = (
    <div class="picture-box">
      <canvas
        ref={canvas}
        class={`picture ${sharp ? 'pixels' : ''}`}
        role="img"
        aria-label={label}
        style={{ width }}
        onMouseMove={showPixel}
        onMouseLeave={() => (pixel.value = '')}
      />
    </div>
  );
  if (plain) return box;
  return (
    <>
      {box}
      <p class="small faint">
        {note}
        {pixel.value}
      </p>
      <p class="actions">
        <label>
          Zoom{' '}
          <select value={zoom.value} onChange={(event) => (zoom.value = Number(event.currentTarget.value))}>
            <option value={0}>fit</option>
            {zooms.map((percent) => (
              <option key={percent} value={percent}>
                {percent} %
              </option>
            ))}
          </select>
        </label>
        <select
          aria-label="Turn the picture"
          value={turn.value}
          onChange={(event) => (turn.value = event.currentTarget.value)}
        >
          {Object.keys(orientations).map((each) => (
            <option key={each}>{each}</option>
          ))}
        </select>
        <button
          type="button"
          onClick={() => canvas.current !== null && saveCanvas(canvas.current, `${name}-${Date.now()}.png`)}
        >
          Save picture
        </button>
        <CheckBox checked={keeps}>save each</CheckBox>
      </p>
    </>
  );
}

const none = { width: 0, height: 0 };
const noMarks: Mark[] = [];

function draw(canvas: HTMLCanvasElement, pixels: Pixels, orientation: Orientation): void {
  const { width, height } = turnedSize(pixels, orientation);
  resize(canvas, width, height);
  const context = canvas.getContext('2d');
  if (context === null) return;
  const isPlain = orientation === orientations[asIs];
  if (isPlain && pixels instanceof ImageData) return context.putImageData(pixels, 0, 0);
  context.setTransform(...matrixOf(orientation, pixels));
  context.drawImage(pixels instanceof ImageData ? canvasOf(pixels) : pixels, 0, 0);
}

function drawMarks(canvas: HTMLCanvasElement, pixels: Pixels, orientation: Orientation, marks: Mark[]): void {
  const context = canvas.getContext('2d');
  if (context === null || marks.length === 0) return;
  const width = Math.max(1, canvas.width / 320);
  context.setTransform(...matrixOf(orientation, pixels));
  context.strokeStyle = markColour;
  context.fillStyle = markColour;
  context.lineWidth = 2 * width;
  context.font = `${12 * width}px system-ui, sans-serif`;
  for (const mark of marks) {
    context.strokeRect(mark.x, mark.y, mark.width, mark.height);
    context.fillText(mark.text, mark.x, mark.y - 3 * width);
  }
}

const markColour = '#ffd23f';

// Raw pixels cannot be turned while they are put into a canvas.
function canvasOf(pixels: ImageData): OffscreenCanvas {
  const canvas = new OffscreenCanvas(pixels.width, pixels.height);
  canvas.getContext('2d')?.putImageData(pixels, 0, 0);
  return canvas;
}
