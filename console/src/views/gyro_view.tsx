// The attitude of a robot as an artificial horizon, and its numbers.

import type { GyroData } from '../codec/messages';
import { degrees } from '../ui/quantities';
import { useStream } from '../ui/use_stream';
import { StreamBox, type ViewProperties } from './view';

const pitchScale = 60; // units of the picture a radian

export function GyroView({ component }: ViewProperties) {
  const stream = useStream<GyroData>(component.address);
  const data = stream.value.value?.data;
  return (
    <StreamBox component={component} stream={stream}>
      {data !== undefined && (
        <div class="gyro">
          <Horizon roll={data.roll} pitch={data.pitch} />
          <table class="fields">
            <tbody>
              {[
                ['Roll', data.roll, data.wRoll, data.aX],
                ['Pitch', data.pitch, data.wPitch, data.aY],
                ['Yaw', data.yaw, data.wYaw, data.aZ],
              ].map(([name, angle, rate, acceleration]) => (
                <tr key={name}>
                  <th scope="row">{name}</th>
                  <td>{degrees(Number(angle))}</td>
                  <td>{degrees(Number(rate))}/s</td>
                  <td>{(Number(acceleration) / 1000).toFixed(2)} m/s²</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </StreamBox>
  );
}

function Horizon({ roll, pitch }: { roll: number; pitch: number }) {
  const turn = (-roll * 180) / Math.PI;
  return (
    <svg
      class="horizon"
      viewBox="-50 -50 100 100"
      role="img"
      aria-label={`roll ${degrees(roll)}, pitch ${degrees(pitch)}`}
    >
      <clipPath id="horizon-edge">
        <circle r="48" />
      </clipPath>
      <g clip-path="url(#horizon-edge)">
        <g transform={`rotate(${turn}) translate(0 ${pitch * pitchScale})`}>
          <rect class="sky" x="-100" y="-200" width="200" height="200" />
          <rect class="earth" x="-100" y="0" width="200" height="200" />
          {[-20, -10, 10, 20].map((angle) => {
            const y = (-angle * Math.PI * pitchScale) / 180;
            return <path key={angle} class="step" d={`M-12 ${y}H12`} />;
          })}
        </g>
      </g>
      <path class="wings" d="M-30 0H-10M10 0H30M0 -2V2" />
    </svg>
  );
}
