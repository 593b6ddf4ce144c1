// Inputs and outputs, and vehicles that are driven by pedals and steering.

import { useSignal } from '@preact/signals';
import { useConsole } from '../app/console';
import type { IoData, VehicleData, VehicleSetValueData } from '../codec/messages';
import { command } from '../model/commands';
import { useAttempt } from '../ui/attempt';
import { needs } from '../ui/needs';
import { degrees } from '../ui/quantities';
import { useStream } from '../ui/use_stream';
import { HoldButton, NumberInput, Values } from './parts';
import { StreamBox, type ViewProperties } from './view';

export function IoView({ component }: ViewProperties) {
  const { client } = useConsole();
  const stream = useStream<IoData>(component.address, 200);
  const index = useSignal('0');
  const value = useSignal('00');
  const { attempt, Failure } = useAttempt();
  const values = stream.value.value?.data.values;
  const set = async () => {
    const at = Number(index.value);
    const byte = Number.parseInt(value.value, 16);
    if (values === undefined || !Number.isInteger(at) || at < 0 || at >= values.length)
      throw new Error(`the index is 0 to ${(values?.length ?? 1) - 1}`);
    if (!/^[0-9a-f]{1,2}$/i.test(value.value)) throw new Error('the value is a byte in hex: 00 to ff');
    await command(client, component, 'Io.SET_DATA', { values: values.map((old, i) => (i === at ? byte : old)) });
  };
  return (
    <>
      <StreamBox component={component} stream={stream}>
        {values !== undefined && (
          <ol class="bytes" start={0} aria-label="Values">
            {[...values].map((byte, i) => (
              <li key={i}>
                <span class="faint">{i}</span> <code>{byte.toString(16).padStart(2, '0')}</code>
              </li>
            ))}
          </ol>
        )}
      </StreamBox>
      <p class="actions">
        <NumberInput label="Index" value={index} />
        <NumberInput label="Value" unit="hex" value={value} />
        <button type="button" {...needs('Io.SET_DATA')} onClick={() => attempt(set)}>
          Set
        </button>
      </p>
      <Failure />
    </>
  );
}

const gears = [[-1, 'reverse'], [0, 'neutral'], ...Array.from({ length: 8 }, (_, i) => [i + 1, `${i + 1}`])] as const;

type Pedal = 'throttle' | 'brake' | 'clutch' | 'steering';
type Switch = 'engine' | 'parkBrake' | 'vehicleProtect';

const pedals: [Pedal, string, number][] = [
  ['throttle', 'Throttle', 0],
  ['brake', 'Brake', 0],
  ['clutch', 'Clutch', 0],
  ['steering', 'Steering', -100],
];
const switches: [Switch, string][] = [
  ['engine', 'Engine'],
  ['parkBrake', 'Parking brake'],
  ['vehicleProtect', 'Protection'],
];

export function VehicleView({ component }: ViewProperties) {
  const { client } = useConsole();
  const stream = useStream<VehicleData>(component.address, 100);
  const wanted = useSignal<Partial<VehicleSetValueData>>({});
  const { attempt, Failure } = useAttempt();
  const data = stream.value.value?.data;
  const change = (part: Partial<VehicleSetValueData>) => {
    wanted.value = { ...wanted.value, ...part };
  };
  const send = () => {
    if (data === undefined) throw new Error('its present state is not known yet');
    const { recordingTime: _, speed: __, omega: ___, ...state } = data;
    return command(client, component, 'Vehicle.SET_VALUE', { ...state, ...wanted.value });
  };
  return (
    <>
      <StreamBox component={component} stream={stream}>
        {data !== undefined && (
          <Values
            of={{
              speed: `${(data.speed / 1000).toFixed(2)} m/s`,
              turning: `${degrees(data.omega)}/s`,
              throttle: `${data.throttle} %`,
              brake: `${data.brake} %`,
              clutch: `${data.clutch} %`,
              steering: `${data.steering} %`,
              gear: `${data.gear}`,
              engine: onOff(data.engine),
              'parking brake': onOff(data.parkBrake),
              protection: onOff(data.vehicleProtect),
              controller: `${data.activeController}`,
            }}
          />
        )}
      </StreamBox>
      <div class="inputs">
        {pedals.map(([name, title, least]) => (
          <label key={name}>
            {title} {wanted.value[name] ?? data?.[name] ?? 0} %
            <input
              type="range"
              min={least}
              max="100"
              value={wanted.value[name] ?? data?.[name] ?? 0}
              onInput={(event) => change({ [name]: Number(event.currentTarget.value) })}
            />
          </label>
        ))}
        <label>
          Gear
          <select
            value={wanted.value.gear ?? data?.gear ?? 0}
            onChange={(event) => change({ gear: Number(event.currentTarget.value) })}
          >
            {gears.map(([gear, title]) => (
              <option key={gear} value={gear}>
                {title}
              </option>
            ))}
          </select>
        </label>
        {switches.map(([name, title]) => (
          <label key={name}>
            <span>
              <input
                type="checkbox"
                checked={(wanted.value[name] ?? data?.[name] ?? 0) !== 0}
                onChange={(event) => change({ [name]: event.currentTarget.checked ? 1 : 0 })}
              />{' '}
              {title}
            </span>
          </label>
        ))}
      </div>
      <HoldButton deed="Vehicle.SET_VALUE" action={() => attempt(async () => send())}>
        Set
      </HoldButton>
      <Failure />
    </>
  );
}

const onOff = (value: number) => (value === 0 ? 'off' : 'on');
