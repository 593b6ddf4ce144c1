// Pictures below the map, such as aerial photographs: each with its world file, of the same name, or one by its corner
// and width. A big one can be cut into sections.

import { useSignal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { useAttempt } from '../ui/attempt';
import { saveFile } from '../ui/save';
import { type ArchivedFile, tar } from '../ui/tar';
import { NumberInput, numberOf } from '../views/parts';
import type { MapModel } from './map_canvas';
import type { Plan } from './scene';
import { sectionsOf } from './sections';
import { type Place, readWorldFile } from './world_file';

const stem = (name: string) => name.replace(/\.\w+$/, '');
const isWorldFile = (name: string) => /\.(tfw|jgw|pgw|wld)$/i.test(name);

interface Picture extends Place {
  name: string;
  picture: ImageBitmap;
}

export function BackgroundMenu({ model }: { model: MapModel }) {
  const [north, east, width] = [useSignal('0'), useSignal('0'), useSignal('100')];
  const files = useRef<HTMLInputElement>(null);
  const { attempt, busy, Failure } = useAttempt();
  const read = async (): Promise<Picture[]> => {
    const chosen = [...(files.current?.files ?? [])];
    const pictures = chosen.filter(({ name }) => !isWorldFile(name));
    if (pictures.length === 0) throw new Error('choose a picture, and its world file if it has one');
    const corner = { north: numberOf('North', north), east: numberOf('East', east) };
    const read = pictures.map(async (file): Promise<Picture> => {
      const picture = await createImageBitmap(file);
      const name = stem(file.name);
      const world = chosen.find((each) => isWorldFile(each.name) && stem(each.name) === name);
      if (world !== undefined) return { name, picture, ...readWorldFile(await world.text(), corner) };
      if (pictures.length > 1) throw new Error(`${file.name} has no world file: only one picture may be without`);
      const cell = (1000 * numberOf('Width', width)) / picture.width;
      if (!(cell > 0)) throw new Error('the width is more than 0');
      return { name, picture, north: 1000 * corner.north, west: 1000 * corner.east, cell };
    });
    return Promise.all(read);
  };
  const show = (pictures: Plan[]) => {
    // The coarse ones first, so that finer ones are above them.
    model.background = pictures.sort((a, b) => b.cell - a.cell);
    model.changed = true;
  };
  const cut = async () => {
    const archives = await Promise.all((await read()).map(filesOf));
    saveFile([tar(archives.flat(), Math.floor(Date.now() / 1000))], 'application/x-tar', 'sections.tar');
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
          <button type="button" onClick={() => attempt(async () => show(await read()))}>
            Show
          </button>
          <button type="button" onClick={() => show([])}>
            Remove
          </button>
          <button
            type="button"
            disabled={busy.value}
            title="Saves them as smaller pictures in several resolutions, with world files: choose some of these for a large map"
            onClick={() => attempt(cut)}
          >
            Cut into sections
          </button>
        </p>
        <Failure />
      </div>
    </details>
  );
}

async function filesOf({ name, picture, ...place }: Picture): Promise<ArchivedFile[]> {
  const files: ArchivedFile[] = [];
  for (const section of sectionsOf(picture, place)) {
    const { x, y, width, height, factor } = section;
    const canvas = new OffscreenCanvas(Math.ceil(width / factor), Math.ceil(height / factor));
    canvas.getContext('2d')?.drawImage(picture, x, y, width, height, 0, 0, width / factor, height / factor);
    const png = new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
    const path = `${name}-${section.name}`;
    files.push({ path: `${path}.png`, content: png }, { path: `${path}.pgw`, content: section.worldFile });
  }
  return files;
}
