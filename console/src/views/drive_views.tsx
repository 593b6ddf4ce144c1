// Drives of turntables and pan-tilt heads. What sets them going wants to be held.

import { useSignal } from '@preact/signals';
import { useConsole } from '../app/console';
import type { PtzDriveData, ServoDriveData } from '../codec/messages';
import { command } from '../model/commands';
import { useAttempt } from '../ui/attempt';
import { needs } from '../ui/needs';
import { degrees, radians } from '../ui/quantities';
import { useStream } from '../ui/use_stream';
import { HoldButton, NumberInput, numberOf, Values } from './parts';
import { StreamBox, type ViewProperties } from './view';

export function ServoView({ component }: ViewProperties) {
  const { client } = useConsole();
  const stream = useStream<ServoDriveData>(component.address);
  const target = useSignal('0');
  const { attempt, Failure } = useAttempt();
  const data = stream.value.value?.data;
  const step = 100;
  const position = data?.position; // unknown: it cannot move by a step from there
  const moveTo = (position: number) =>
    command(client, component, 'ServoDrive.MOVE_POS', { position, replyPositionReached: 0 });
  return (
    <>
      <StreamBox component={component} stream={stream}>
        {data !== undefined && <Values of={{ position: `${data.position}` }} />}
      </StreamBox>
      <p class="actions">
        <HoldButton deed="ServoDrive.HOME" action={() => attempt(() => command(client, component, 'ServoDrive.HOME'))}>
          Home
        </HoldButton>
        <button
          type="button"
          {...needs('ServoDrive.MOVE_POS', { disabled: position === undefined })}
          onClick={() => position !== undefined && attempt(() => moveTo(position - step))}
        >
          −{step}
        </button>
        <button
          type="button"
          {...needs('ServoDrive.MOVE_POS', { disabled: position === undefined })}
          onClick={() => position !== undefined && attempt(() => moveTo(position + step))}
        >
          +{step}
        </button>
        <button
          type="button"
          class="stop"
          {...needs('ServoDrive.MOVE_VEL')}
          onClick={() => attempt(() => command(client, component, 'ServoDrive.MOVE_VEL', { vel: 0 }))}
        >
          Stop
        </button>
      </p>
      <p class="actions">
        <NumberInput label="Target" value={target} />
        <button
          type="button"
          {...needs('ServoDrive.MOVE_POS')}
          onClick={() => attempt(async () => moveTo(numberOf('Target', target)))}
        >
          Go there
        </button>
        <HoldButton
          deed="ServoDrive.MOVE_VEL"
          action={() =>
            attempt(async () =>
              command(client, component, 'ServoDrive.MOVE_VEL', { vel: numberOf('Velocity', target) }),
            )
          }
        >
          Turn at this velocity
        </HoldButton>
      </p>
      <Failure />
    </>
  );
}

export function PtzView({ component }: ViewProperties) {
  const { client } = useConsole();
  const stream = useStream<PtzDriveData>(component.address);
  const [pan, tilt, zoom] = [useSignal('0'), useSignal('0'), useSignal('0')];
  const { attempt, Failure } = useAttempt();
  const data = stream.value.value?.data;
  const entered = () => ({
    pan: radians(numberOf('Pan', pan)),
    tilt: radians(numberOf('Tilt', tilt)),
    zoom: numberOf('Zoom', zoom),
  });
  const goTo = async () => {
    const { pan: posPan, tilt: posTilt, zoom: posZoom } = entered();
    await command(client, component, 'PtzDrive.MOVE_POS', { posPan, posTilt, posZoom });
  };
  const turn = async () => {
    const { pan: velPan, tilt: velTilt, zoom: velZoom } = entered();
    await command(client, component, 'PtzDrive.MOVE_VEL', { velPan, velTilt, velZoom });
  };
  const stop = () => command(client, component, 'PtzDrive.MOVE_VEL', { velPan: 0, velTilt: 0, velZoom: 0 });
  return (
    <>
      <StreamBox component={component} stream={stream}>
        {data !== undefined && (
          <Values
            of={{ pan: degrees(data.posPan), tilt: degrees(data.posTilt), zoom: `${data.posZoom.toFixed(0)} %` }}
          />
        )}
      </StreamBox>
      <p class="actions">
        <NumberInput label="Pan" unit="°" value={pan} />
        <NumberInput label="Tilt" unit="°" value={tilt} />
        <NumberInput label="Zoom" unit="%" value={zoom} />
      </p>
      <p class="actions">
        <button type="button" {...needs('PtzDrive.MOVE_POS')} onClick={() => attempt(goTo)}>
          Go there
        </button>
        <HoldButton deed="PtzDrive.MOVE_VEL" action={() => attempt(turn)}>
          Turn at these per second
        </HoldButton>
        <HoldButton deed="PtzDrive.HOME" action={() => attempt(() => command(client, component, 'PtzDrive.HOME'))}>
          Home
        </HoldButton>
        <button type="button" class="stop" {...needs('PtzDrive.MOVE_VEL')} onClick={() => attempt(stop)}>
          Stop
        </button>
      </p>
      <Failure />
    </>
  );
}
