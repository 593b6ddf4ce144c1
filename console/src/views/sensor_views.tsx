// Small sensors: a compass, a clock, a satellite receiver, a joystick.

import { valueName } from '../codec/catalogue';
import type { ClockData, CompassData, GpsData, JoystickData } from '../codec/messages';
import { degrees, heading, metres, utcText } from '../ui/quantities';
import { useStream } from '../ui/use_stream';
import { Values } from './parts';
import { StreamBox, type ViewProperties } from './view';

const slow = 500; // ms

export function CompassView({ component }: ViewProperties) {
  const stream = useStream<CompassData>(component.address);
  const data = stream.value.value?.data;
  return (
    <StreamBox component={component} stream={stream}>
      {data !== undefined && (
        <div class="gyro">
          <svg class="horizon" viewBox="-50 -50 100 100" role="img" aria-label={`north, ${heading(data.orientation)}`}>
            <circle class="dial" r="46" />
            <text y="-32">N</text>
            <path
              class="needle"
              transform={`rotate(${(data.orientation * 180) / Math.PI})`}
              d="M0 -28L7 16L0 9L-7 16z"
            />
          </svg>
          <Values of={{ Orientation: heading(data.orientation), 'standard deviation': degrees(data.varOrientation) }} />
        </div>
      )}
    </StreamBox>
  );
}

const days = ['Sunday', 'Monday', 'Tuesday', 'Wednesday', 'Thursday', 'Friday', 'Saturday'];

export function ClockView({ component }: ViewProperties) {
  const stream = useStream<ClockData>(component.address, slow);
  const data = stream.value.value?.data;
  const two = (value: number) => `${value}`.padStart(2, '0');
  return (
    <StreamBox component={component} stream={stream}>
      {data !== undefined && (
        <>
          <p class="large">
            {two(data.hour)}:{two(data.minute)}:{two(data.second)}
          </p>
          <Values
            of={{
              date: `${data.year}-${two(data.month)}-${two(data.day)}`,
              weekday: days[data.dayOfWeek % 7] ?? `${data.dayOfWeek}`,
              UTC: utcText(data.utcTime),
              synchronised: data.syncMode === 0 ? 'no' : 'yes',
              'standard deviation': `${data.varT} ms`,
            }}
          />
        </>
      )}
    </StreamBox>
  );
}

export function GpsView({ component }: ViewProperties) {
  const stream = useStream<GpsData>(component.address, slow);
  const data = stream.value.value?.data;
  return (
    <StreamBox component={component} stream={stream}>
      {data !== undefined && (
        <Values
          of={{
            fix: valueName('GpsData.mode', data.mode) ?? `${data.mode}`,
            satellites: `${data.satelliteNum}`,
            PDOP: data.pdop.toFixed(1),
            latitude: `${((data.latitude * 180) / Math.PI).toFixed(7)}°`,
            longitude: `${((data.longitude * 180) / Math.PI).toFixed(7)}°`,
            altitude: metres(data.altitude),
            heading: heading(data.heading),
            speed: `${(data.speed / 1000).toFixed(2)} m/s`,
            north: metres(data.pos.x),
            east: metres(data.pos.y),
            down: metres(data.pos.z),
            'heading of the position': heading(data.pos.rho),
            'deviation north': metres(data.var.x),
            'deviation east': metres(data.var.y),
            'deviation down': metres(data.var.z),
            'deviation of heading': degrees(data.var.rho),
            UTC: utcText(data.utcTime),
          }}
        />
      )}
    </StreamBox>
  );
}

export function JoystickView({ component }: ViewProperties) {
  const stream = useStream<JoystickData>(component.address);
  const data = stream.value.value?.data;
  if (data === undefined) return <StreamBox component={component} stream={stream} children={null} />;
  const { x, y, z } = data.position;
  const pressed = Array.from({ length: 32 }, (_, i) => i).filter((i) => ((data.buttons >>> i) & 1) === 1);
  return (
    <StreamBox component={component} stream={stream}>
      <div class="gyro">
        <svg class="horizon" viewBox="-50 -50 100 100" role="img" aria-label={`forward ${x} %, right ${y} %`}>
          <circle class="dial" r="46" />
          <circle class="knob" r="9" cx={0.4 * y} cy={-0.4 * x} />
        </svg>
        <Values
          of={{
            forward: `${x} %`,
            'to the right': `${y} %`,
            sideways: `${z} %`,
            buttons: pressed.length === 0 ? 'none' : pressed.map((i) => i + 1).join(', '),
          }}
        />
      </div>
    </StreamBox>
  );
}
