// Where a robot is, where it drives, and what it is set to.

import { type Signal, useSignal } from '@preact/signals';
import { useId } from 'preact/hooks';
import { useConsole } from '../app/console';
import { structOf, valueName } from '../codec/catalogue';
import type {
  ObjRecogData,
  ObjRecogObject,
  OdometryData,
  PilotData,
  PlannerData,
  Position3d,
  PositionData,
} from '../codec/messages';
import { command } from '../model/commands';
import { useAttempt } from '../ui/attempt';
import { needs } from '../ui/needs';
import { degrees, heading as headingText, metres, radians } from '../ui/quantities';
import { SoundSwitch } from '../ui/sound_switch';
import { useStream } from '../ui/use_stream';
import { FieldTable } from './fields_view';
import { GoalView } from './goal_view';
import { GpsUpdate } from './gps_update';
import { RobotMap } from './map_view';
import { NumberInput, numberOf, Values } from './parts';
import { StreamBox, type ViewProperties } from './view';

const period = 200; // ms

function Pose({ pos, deviation }: { pos: Position3d; deviation?: Position3d }) {
  const rows: [string, keyof Position3d, (value: number) => string][] = [
    ['North', 'x', metres],
    ['East', 'y', metres],
    ['Down', 'z', metres],
    ['Roll', 'phi', degrees],
    ['Pitch', 'psi', degrees],
    ['Heading', 'rho', headingText],
  ];
  return (
    <table class="fields">
      <tbody>
        {rows.map(([name, key, text]) => (
          <tr key={key}>
            <th scope="row">{name}</th>
            <td class="number">{text(pos[key])}</td>
            {deviation !== undefined && <td class="number faint">± {text(deviation[key])}</td>}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

export function OdometryView({ component }: ViewProperties) {
  const { client } = useConsole();
  const stream = useStream<OdometryData>(component.address, period);
  const { attempt, Failure } = useAttempt();
  const data = stream.value.value?.data;
  return (
    <>
      <StreamBox component={component} stream={stream}>
        {data !== undefined && <Pose pos={data.pos} />}
      </StreamBox>
      <button
        type="button"
        {...needs('Odometry.RESET')}
        onClick={() => attempt(() => command(client, component, 'Odometry.RESET'))}
      >
        Set to zero
      </button>
      <Failure />
    </>
  );
}

// Throws which of the inputs is no number.
function enteredPose(
  north: Signal<string>,
  east: Signal<string>,
  turn: Signal<string>,
  down?: Signal<string>,
): Position3d {
  return {
    x: Math.round(1000 * numberOf('North', north)),
    y: Math.round(1000 * numberOf('East', east)),
    z: down === undefined ? 0 : Math.round(1000 * numberOf('Down', down)),
    phi: 0,
    psi: 0,
    rho: radians(numberOf('Heading', turn)),
  };
}

// Standard deviations of what somebody enters.
const enteredDeviation: Position3d = { x: 300, y: 300, z: 0, phi: 0, psi: 0, rho: 0.2 };

export function PositionView({ component }: ViewProperties) {
  const { client } = useConsole();
  const stream = useStream<PositionData>(component.address, period);
  const [x, y, heading] = [useSignal('0'), useSignal('0'), useSignal('0')];
  const { attempt, Failure } = useAttempt();
  const data = stream.value.value?.data;
  const update = async () => {
    const pos = enteredPose(x, y, heading);
    await command(client, component, 'Position.UPDATE', { recordingTime: 0, pos, var: enteredDeviation });
  };
  return (
    <>
      <StreamBox component={component} stream={stream}>
        {data !== undefined && <Pose pos={data.pos} deviation={data.var} />}
      </StreamBox>
      <p class="actions">
        <NumberInput label="North" unit="m" value={x} />
        <NumberInput label="East" unit="m" value={y} />
        <NumberInput label="Heading" unit="°" value={heading} />
        <button type="button" {...needs('Position.UPDATE')} onClick={() => attempt(update)}>
          It is here
        </button>
      </p>
      <Failure />
      <GpsUpdate position={component} />
      <GoalView position={component} pose={data?.pos} />
    </>
  );
}

export function PilotView({ component }: ViewProperties) {
  const { client, leases } = useConsole();
  const stream = useStream<PilotData>(component.address, period);
  const [x, y, down, heading] = [useSignal('0'), useSignal('0'), useSignal('0'), useSignal('0')];
  const speed = useSignal('0.5');
  const { attempt, Failure } = useAttempt();
  const data = stream.value.value?.data;
  const hold = (holdState: number) => attempt(() => command(client, component, 'Pilot.HOLD_COMMAND', { holdState }));
  const send = async () => {
    const pos = enteredPose(x, y, heading, down);
    const limit = Math.round(1000 * numberOf('Speed', speed));
    await leases.during(component.system, () =>
      command(client, component, 'Pilot.SET_DESTINATION', { pos, speed: limit }, 20000),
    );
  };
  return (
    <>
      <StreamBox component={component} stream={stream}>
        {data !== undefined && (
          <Values
            of={{
              state: valueName('PilotData.pilotState', data.pilotState) ?? `${data.pilotState}`,
              speed: `${(data.speed / 1000).toFixed(2)} m/s`,
              'to the goal': data.distanceToDest < 0 ? 'no goal' : metres(data.distanceToDest),
              'goal north': metres(data.dest.x),
              'goal east': metres(data.dest.y),
              'goal heading': headingText(data.dest.rho),
            }}
          />
        )}
      </StreamBox>
      <RobotMap component={component} />
      <p class="actions">
        <button type="button" {...needs('Pilot.HOLD_COMMAND')} onClick={() => hold(1)}>
          Hold
        </button>
        <button type="button" {...needs('Pilot.HOLD_COMMAND')} onClick={() => hold(0)}>
          Go on
        </button>
      </p>
      <p class="actions">
        <NumberInput label="North" unit="m" value={x} />
        <NumberInput label="East" unit="m" value={y} />
        <NumberInput label="Down" unit="m" value={down} />
        <NumberInput label="Heading" unit="°" value={heading} />
        <NumberInput label="Speed" unit="m/s" value={speed} />
        <button type="button" {...needs('Pilot.SET_DESTINATION')} onClick={() => attempt(send)}>
          Set destination
        </button>
      </p>
      <Failure />
    </>
  );
}

// 1100 Hz at the robot, an octave lower each 3 m.
const nearTone = (distance: number) => 1100 * 2 ** (-Math.min(distance, 12_000) / 3000);

const objectFields = structOf('ObjRecogObject').fields;

export function ObjectsView({ component }: ViewProperties) {
  const stream = useStream<ObjRecogData>(component.address, period);
  const seen = stream.value.value?.data;
  const objects = seen?.objects ?? [];
  const from = seen?.refPos ?? { x: 0, y: 0 };
  const [x, y, heading, id] = [useSignal('0'), useSignal('0'), useSignal('0'), useSignal('0')];
  const { client } = useConsole();
  const { attempt, Failure } = useAttempt();
  const estimate = async () => {
    const object = { objectId: numberOf('Id', id), pos: enteredPose(x, y, heading) } as ObjRecogObject;
    await command(client, component, 'ObjRecog.SET_ESTIMATE', { objects: [object] });
  };
  const shown = useSignal<number | undefined>(undefined); // the id of that with all values
  const chosen = objects.find(({ objectId }) => objectId === shown.value);
  const nearest = Math.min(...objects.map(({ pos }) => Math.hypot(pos.x - from.x, pos.y - from.y)));
  return (
    <StreamBox component={component} stream={stream}>
      {objects.length === 0 && <p class="faint">It sees no objects.</p>}
      <SoundSwitch label="Sound: the nearer, the higher" frequency={nearTone(nearest)} isHeard={objects.length > 0} />
      {objects.length > 0 && <ObjectTable objects={objects} shown={shown} />}
      {chosen !== undefined && <FieldTable fields={objectFields} data={{ ...chosen }} si={true} />}
      <details>
        <summary>Say where an object is</summary>
        <p class="actions">
          <NumberInput label="North" unit="m" value={x} />
          <NumberInput label="East" unit="m" value={y} />
          <NumberInput label="Heading" unit="°" value={heading} />
          <NumberInput label="Id" value={id} />
          <button type="button" {...needs('ObjRecog.SET_ESTIMATE')} onClick={() => attempt(estimate)}>
            Set estimate
          </button>
        </p>
        <Failure />
      </details>
    </StreamBox>
  );
}

interface ObjectTableProperties {
  objects: ObjRecogObject[];
  shown: Signal<number | undefined>;
}

function ObjectTable({ objects, shown }: ObjectTableProperties) {
  return (
    <div class="sheet">
      <table class="list one-line">
        <thead>
          <tr>
            <th scope="col">Id</th>
            <th scope="col">Kind</th>
            <th scope="col">North, east in m</th>
            <th scope="col">Speed</th>
            <th scope="col">
              <abbr title="How sure it is of the object">Sure</abbr>
            </th>
          </tr>
        </thead>
        <tbody>
          {objects.map(({ objectId, type, pos, vel, prob }) => (
            <tr key={objectId}>
              <th scope="row">
                <button
                  type="button"
                  class="quiet"
                  aria-pressed={shown.value === objectId}
                  aria-label={`All values of ${objectId}`}
                  onClick={() => (shown.value = shown.value === objectId ? undefined : objectId)}
                >
                  {objectId}
                </button>
              </th>
              <td>{valueName('ObjRecogObject.type', type) ?? `type ${type}`}</td>
              <td>
                {(pos.x / 1000).toFixed(2)}, {(pos.y / 1000).toFixed(2)}
              </td>
              <td>{(Math.hypot(vel.x, vel.y) / 1000).toFixed(2)} m/s</td>
              <td>{(100 * prob).toFixed(0)} %</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

export function PlannerView({ component }: ViewProperties) {
  const { client } = useConsole();
  const stream = useStream<PlannerData>(component.address, 500);
  const text = useSignal('');
  const sent = useSignal<string[]>([]);
  const list = useId();
  const { attempt, Failure } = useAttempt();
  const data = stream.value.value?.data;
  const send = (event: Event) => {
    event.preventDefault();
    sent.value = [...new Set([text.value, ...sent.value])];
    const line = { text: text.value, stringLen: new TextEncoder().encode(text.value).length };
    attempt(() => command(client, component, 'Planner.COMMAND', { commands: [line] }));
  };
  return (
    <>
      <StreamBox component={component} stream={stream}>
        {data !== undefined && (
          <>
            <Values of={{ state: `${data.state}` }} />
            <ol class="small">
              {data.messages.map((message, i) => (
                <li key={i}>{message.text}</li>
              ))}
            </ol>
          </>
        )}
      </StreamBox>
      <form class="actions" onSubmit={send}>
        <input
          aria-label="Command"
          list={list}
          value={text.value}
          onInput={(event) => {
            text.value = event.currentTarget.value;
          }}
        />
        <datalist id={list}>
          {sent.value.map((each) => (
            <option key={each} value={each} />
          ))}
        </datalist>
        <button type="submit" {...needs('Planner.COMMAND')}>
          Send
        </button>
        <button type="button" onClick={() => (text.value = '')}>
          Clear
        </button>
      </form>
      <Failure />
    </>
  );
}
