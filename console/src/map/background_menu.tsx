// The picture below the map, such as an aerial photograph, with its world file or by its corner and width.

import { useSignal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { useAttempt } from '../ui/attempt';
import { NumberInput, numberOf } from '../views/parts';
import type { MapModel } from './map_canvas';
import { type Place, readWorldFile } from './world_file';

const isWorldFile = (name: string) => /\.(tfw|jgw|pgw|wld)$/i.test(name);

export function BackgroundMenu({ model }: { model: MapModel }) {
  const [north, east, width] = [useSignal('0'), useSignal('0'), useSignal('100')];
  const files = useRef<HTMLInputElement>(null);
  const { attempt, Failure } = useAttempt();
  const show = async () => {
    const chosen = [...(files.current?.files ?? [])];
    const world = chosen.find(({ name }) => isWorldFile(name));
    const file = chosen.find(({ name }) => !isWorldFile(name));
    if (file === undefined) throw new Error('choose a picture, and its world file if it has one');
    const picture = await createImageBitmap(file);
    const corner = { north: numberOf('North', north), east: numberOf('East', east) };
    const place: Place =
      world !== undefined
        ? readWorldFile(await world.text(), corner)
        : {
            north: 1000 * corner.north,
            west: 1000 * corner.east,
            cell: (1000 * numberOf('Width', width)) / picture.width,
          };
    if (!(place.cell > 0)) throw new Error('the width is more than 0');
    model.background = { picture, ...place };
    model.changed = true;
  };
  const remove = () => {
    model.background = undefined;
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
          aria-label="Picture and world file"
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
