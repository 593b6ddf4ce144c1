// A chassis: how it moves, its battery, and who may drive it.

import { useSignal } from '@preact/signals';
import { nameOf, useConsole } from '../app/console';
import { classId } from '../codec/catalogue';
import type { ChassisData } from '../codec/messages';
import { command, noPilot } from '../model/commands';
import { useAttempt } from '../ui/attempt';
import { needs } from '../ui/needs';
import { degrees } from '../ui/quantities';
import { SoundSwitch } from '../ui/sound_switch';
import { useStream } from '../ui/use_stream';
import { StreamBox, type ViewProperties } from './view';

export function ChassisView({ component }: ViewProperties) {
  const console = useConsole();
  const stream = useStream<ChassisData>(component.address);
  const { attempt, Failure } = useAttempt();
  const data = stream.value.value?.data;
  const pilots = console.fleet.robot(component.system)?.components.filter(isPilot) ?? [];
  const choose = (activePilot: number) =>
    attempt(() => command(console.client, component, 'Chassis.SET_ACTIVE_PILOT', { activePilot }));
  return (
    <StreamBox component={component} stream={stream}>
      {data !== undefined && (
        <>
          <Speed data={data} />
          <fieldset>
            <legend>Who may drive</legend>
            {pilots.map(({ address }) => (
              <label key={address}>
                <input
                  type="radio"
                  name={`pilot-${component.address}`}
                  checked={data.activePilot === address}
                  {...needs('Chassis.SET_ACTIVE_PILOT')}
                  onChange={() => choose(address)}
                />{' '}
                {nameOf(console, address)}
              </label>
            ))}
            <label>
              <input
                type="radio"
                name={`pilot-${component.address}`}
                checked={data.activePilot >>> 0 === noPilot}
                {...needs('Chassis.SET_ACTIVE_PILOT')}
                onChange={() => choose(noPilot)}
              />{' '}
              nobody
            </label>
          </fieldset>
          <OtherPilot choose={choose} active={data.activePilot} />
          <SpeedSound data={data} />
        </>
      )}
      <Failure />
    </StreamBox>
  );
}

// A pilot that is not of this robot, by its address.
function OtherPilot({ choose, active }: { choose: (address: number) => void; active: number }) {
  const text = useSignal('');
  const address = Number.parseInt(text.value, 16);
  return (
    <p class="actions">
      <label>
        Another one{' '}
        <input
          size={10}
          placeholder={(active >>> 0).toString(16).padStart(8, '0')}
          aria-label="Address of another pilot, in hex"
          value={text.value}
          onInput={(event) => (text.value = event.currentTarget.value)}
        />
      </label>
      <button
        type="button"
        {...needs('Chassis.SET_ACTIVE_PILOT', { disabled: !/^[0-9a-f]{1,8}$/i.test(text.value) })}
        onClick={() => choose(address)}
      >
        Let it drive
      </button>
    </p>
  );
}

const restTone = 110; // Hz
const toneASpeed = 0.22; // Hz for each mm/s

// One hears how fast it moves while one looks at it.
function SpeedSound({ data }: { data: ChassisData }) {
  const speed = Math.hypot(data.vx, data.vy);
  const frequency = restTone + toneASpeed * speed;
  return <SoundSwitch label="Sound: the faster, the higher" frequency={frequency} isHeard={speed > 1} />;
}

// For pages that show how it moves beside other things.
export function ChassisSpeed({ component }: ViewProperties) {
  const stream = useStream<ChassisData>(component.address);
  const data = stream.value.value?.data;
  return (
    <StreamBox component={component} stream={stream}>
      {data !== undefined && <Speed data={data} />}
    </StreamBox>
  );
}

function Speed({ data }: { data: ChassisData }) {
  return (
    <dl class="values">
      <Quantity name="forward" value={`${(data.vx / 1000).toFixed(2)} m/s`} />
      <Quantity name="to the right" value={`${(data.vy / 1000).toFixed(2)} m/s`} />
      <Quantity name="turning clockwise" value={`${degrees(data.omega)}/s`} />
      <Quantity name="battery" value={data.battery > 0 ? `${data.battery.toFixed(1)} V` : 'not known'} />
    </dl>
  );
}

const isPilot = (component: { classId: number }) => component.classId === classId('Pilot');

function Quantity({ name, value }: { name: string; value: string }) {
  return (
    <div>
      <dt>{name}</dt>
      <dd>{value}</dd>
    </div>
  );
}
