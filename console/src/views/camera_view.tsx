// The picture of a camera, and its format.

import { useSignal } from '@preact/signals';
import { useEffect, useMemo } from 'preact/hooks';
import { useConsole } from '../app/console';
import { namesOf, valueName } from '../codec/catalogue';
import type { CameraData, ObjRecogData } from '../codec/messages';
import { firstOf } from '../map/follow';
import { command } from '../model/commands';
import type { Component } from '../model/fleet';
import { useAttempt } from '../ui/attempt';
import { needs } from '../ui/needs';
import { useStream } from '../ui/use_stream';
import { isGrey, modeName, NewestPicture, PictureMemory, release } from './camera_picture';
import { colourTable, tableNames } from './colour_tables';
import { type Mark, Picture, type Pixels } from './picture';
import { StreamBox, type ViewProperties } from './view';

const period = 100; // ms
const objectPeriod = 200;

function useCamera(address: number, table: string) {
  const stream = useStream<CameraData>(address, period);
  const pixels = useSignal<Pixels | undefined>(undefined);
  const { attempt, Failure } = useAttempt();
  const memory = useMemo(() => new PictureMemory(), []);
  const newest = useMemo(() => new NewestPicture((picture) => (pixels.value = picture)), [address]);
  const data = stream.value.value?.data;
  const shown = pixels.value;
  useEffect(() => {
    if (data !== undefined) void attempt(() => newest.take(memory.picture(data, colourTable(table))));
  }, [data, table]);
  useEffect(() => () => newest.end(), [newest]);
  useEffect(() => () => release(shown), [shown]);
  return { stream, data, pixels: shown, Failure };
}

// For pages that show the picture beside other things.
export function CameraSight({ component }: ViewProperties) {
  const { stream, pixels, Failure } = useCamera(component.address, '');
  return (
    <StreamBox component={component} stream={stream}>
      <Picture pixels={pixels} label="Picture of the camera" name="camera" plain />
      <Failure />
    </StreamBox>
  );
}

export function CameraView({ component }: ViewProperties) {
  const table = useSignal('');
  const { stream, data, pixels, Failure } = useCamera(component.address, table.value);
  const marks = useObjectMarks(component);
  const note = data === undefined ? '' : `${data.width} × ${data.height}, ${modeName(data.mode)}`;
  return (
    <StreamBox component={component} stream={stream}>
      <Picture pixels={pixels} label="Picture of the camera" name="camera" note={note} marks={marks} />
      <Failure />
      {data !== undefined && isGrey(data) && (
        <label>
          Colours{' '}
          <select value={table.value} onChange={(event) => (table.value = event.currentTarget.value)}>
            <option value="">as they are</option>
            {tableNames.map((name) => (
              <option key={name}>{name}</option>
            ))}
          </select>
        </label>
      )}
      <Format component={component} />
    </StreamBox>
  );
}

// The parts of the picture in which the robot has found objects.
function useObjectMarks(component: Component): Mark[] {
  const console = useConsole();
  const robot = console.fleet.robot(component.system);
  const recognition = robot === undefined ? undefined : firstOf(robot, 'ObjRecog');
  const objects = useStream<ObjRecogData>(recognition?.address, objectPeriod).value.value?.data.objects;
  return useMemo(
    () =>
      (objects ?? [])
        .filter(({ imageArea: { width, height } }) => width > 0 && height > 0)
        .map(({ objectId, type, imageArea }) => ({
          ...imageArea,
          text: `${objectId} ${valueName('ObjRecogObject.type', type) ?? ''}`,
        })),
    [objects],
  );
}

const unchanged = -1;
const sizes = ['160x120', '320x240', '352x288', '640x480', '1280x960'];

function Format({ component }: ViewProperties) {
  const { client } = useConsole();
  const size = useSignal('');
  const mode = useSignal('');
  const { attempt, Failure } = useAttempt();
  const set = async () => {
    const [width = unchanged, height = unchanged] = size.value === '' ? [] : size.value.split('x').map(Number);
    const wanted = { width, height, depth: unchanged, mode: mode.value === '' ? unchanged : Number(mode.value) };
    await command(client, component, 'Camera.SET_FORMAT', wanted);
  };
  return (
    <details>
      <summary>Format</summary>
      <p class="actions">
        <label>
          Size{' '}
          <select value={size.value} onChange={(event) => (size.value = event.currentTarget.value)}>
            <option value="">as it is</option>
            {sizes.map((each) => (
              <option key={each} value={each}>
                {each.replace('x', ' × ')}
              </option>
            ))}
          </select>
        </label>
        <label>
          Mode{' '}
          <select value={mode.value} onChange={(event) => (mode.value = event.currentTarget.value)}>
            <option value="">as it is</option>
            {namesOf('CameraFormatData.mode').map(([name, number]) => (
              <option key={name} value={number}>
                {name}
              </option>
            ))}
          </select>
        </label>
        <button
          type="button"
          {...needs('Camera.SET_FORMAT', { disabled: size.value === '' && mode.value === '' })}
          onClick={() => attempt(set)}
        >
          Set
        </button>
      </p>
      <Failure />
    </details>
  );
}
