// Pictures below the map, such as aerial photographs: each with its world file, of the same name, or one by its corner
// and width.

import { useSignal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { useAttempt } from '../ui/attempt';
import { NumberInput, numberOf } from '../views/parts';
import type { MapModel } from './map_canvas';
import type { Plan } from './scene';
import { readWorldFile } from './world_file';

const stem = (name: string) => name.replace(/\.\w+$/, '');
const isWorldFile = (name: string) => /\.(tfw|jgw|pgw|wld)$/i.test(name);

export function BackgroundMenu({ model }: { model: MapModel }) {
  const [north, east, width] = [useSignal('0'), useSignal('0'), useSignal('100')];
  const files = useRef<HTMLInputElement>(null);
  const { attempt, Failure } = useAttempt();
  const show = async () => {
    const chosen = [...(files.current?.files ?? [])];
    const pictures = chosen.filter(({ name }) => !isWorldFile(name));
    if (pictures.length === 0) throw new Error('choose a picture, and its world file if it has one');
    const corner = { north: numberOf('North', north), east: numberOf('East', east) };
    const plans = pictures.map(async (file): Promise<Plan> => {
      const picture = await createImageBitmap(file);
      const world = chosen.find(({ name }) => isWorldFile(name) && stem(name) === stem(file.name));
      if (world !== undefined) return { picture, ...readWorldFile(await world.text(), corner) };
      if (pictures.length > 1) throw new Error(`${file.name} has no world file: only one picture may be without`);
      const cell = (1000 * numberOf('Width', width)) / picture.width;
      if (!(cell > 0)) throw new Error('the width is more than 0');
      return { picture, north: 1000 * corner.north, west: 1000 * corner.east, cell };
    });
    // The coarse ones first, so that finer ones are above them.
    model.background = (await Promise.all(plans)).sort((a, b) => b.cell - a.cell);
    model.changed = true;
  };
  const remove = () => {
    model.background = [];
    model.changed = true;
  };
  return (
    <details class="menu">
      <summary>Background</summary>
      <div>
        <input
          ref={files}
          type="file"
          multiple
          accept="image/*,.tfw,.jgw,.pgw,.wld"
          aria-label="Pictures and world files"
        />
        <p class="small faint">
          North and east of its upper left corner; with a world file: the coordinates of the map’s origin in it.
        </p>
        <NumberInput label="North" unit="m" value={north} />
        <NumberInput label="East" unit="m" value={east} />
        <NumberInput label="Width" unit="m" value={width} />
        <p class="actions">
          <button type="button" onClick={() => attempt(show)}>
            Show
          </button>
          <button type="button" onClick={remove}>
            Remove
          </button>
        </p>
        <Failure />
      </div>
    </details>
  );
}
