// The picture of a camera.

import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import type { CameraData } from '../codec/messages';
import { saveCanvas } from '../ui/save';
import { useStream } from '../ui/use_stream';
import { modeName, pictureOf } from './camera_picture';
import { StreamBox, type ViewProperties } from './view';

const period = 100; // ms

export function CameraView({ component }: ViewProperties) {
  const stream = useStream<CameraData>(component.address, period);
  const canvas = useRef<HTMLCanvasElement>(null);
  const trouble = useSignal('');
  const pixel = useSignal('');
  const value = stream.value.value;
  useEffect(() => {
    if (canvas.current === null || value === undefined) return;
    paint(canvas.current, value.data).then(
      () => {
        trouble.value = '';
      },
      (error: Error) => {
        trouble.value = error.message;
      },
    );
  }, [value]);
  const showPixel = (event: MouseEvent) => {
    const element = canvas.current;
    if (element === null) return;
    const x = Math.floor((event.offsetX * element.width) / element.clientWidth);
    const y = Math.floor((event.offsetY * element.height) / element.clientHeight);
    const [red, green, blue] = element.getContext('2d')?.getImageData(x, y, 1, 1).data ?? [];
    pixel.value = `; pixel ${x}, ${y}: ${red} ${green} ${blue}`;
  };
  return (
    <StreamBox component={component} stream={stream}>
      <canvas
        ref={canvas}
        class="picture"
        role="img"
        aria-label="Picture of the camera"
        onMouseMove={showPixel}
        onMouseLeave={() => (pixel.value = '')}
      />
      {trouble.value !== '' && <p class="bad">{trouble.value}</p>}
      {value !== undefined && (
        <p class="small faint">
          {value.data.width} × {value.data.height}, {modeName(value.data.mode)}
          {pixel.value}
        </p>
      )}
      <p class="actions">
        <button type="button" onClick={() => canvas.current !== null && saveCanvas(canvas.current, 'camera.png')}>
          Save picture
        </button>
      </p>
    </StreamBox>
  );
}

async function paint(canvas: HTMLCanvasElement, data: CameraData): Promise<void> {
  const picture = await pictureOf(data);
  canvas.width = picture.width;
  canvas.height = picture.height;
  const context = canvas.getContext('2d');
  if (picture instanceof ImageData) context?.putImageData(picture, 0, 0);
  else {
    context?.drawImage(picture, 0, 0);
    picture.close();
  }
}
