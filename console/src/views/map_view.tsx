// What a component knows of the map, on a small map of its robot: a path, particles, features.

import { useSignal } from '@preact/signals';
import { useEffect, useMemo } from 'preact/hooks';
import { useConsole } from '../app/console';
import { className } from '../codec/catalogue';
import { followedOf, followRobot } from '../map/follow';
import { MapCanvas, newMapModel } from '../map/map_canvas';
import { allLayers } from '../map/paint';
import { emptyScene } from '../map/scene';
import { command } from '../model/commands';
import { useAttempt } from '../ui/attempt';
import { needs } from '../ui/needs';
import { useStream, useVisible } from '../ui/use_stream';
import { StreamBox, type ViewProperties } from './view';

const slow = 1000; // ms: only whether data come

export function MapView({ component }: ViewProperties) {
  const stream = useStream<Record<string, unknown>>(component.address, slow);
  return (
    <StreamBox component={component} stream={stream}>
      <RobotMap component={component} />
      <MapFile component={component} />
    </StreamBox>
  );
}

// A small map of the robot of a component.
export function RobotMap({ component }: ViewProperties) {
  const console = useConsole();
  const model = useMemo(() => newMapModel({ ...allLayers, particles: true }), []);
  const robot = console.fleet.robots.value.find(({ system }) => system === component.system);
  const visible = useVisible();
  model.followed = component.system;
  useEffect(() => {
    if (robot === undefined || !visible) return;
    const scene = emptyScene(robot.system, console.goals.of(robot.system));
    model.scenes.set(robot.system, scene);
    return followRobot(console, robot, scene, () => {
      model.changed = true;
    });
  }, [robot === undefined ? '' : followedOf(robot), visible]);
  return (
    <>
      <div class="small-map">
        <MapCanvas model={model} label={`Map of ${className(component.classId)}`} choose={undefined} />
      </div>
      <p class="small">
        <a href={`#/map?robots=${component.system}`}>Open the map</a>
      </p>
    </>
  );
}

// Maps are files in the folder of the component, on its host.
export function MapFile({ component }: ViewProperties) {
  const { client } = useConsole();
  const name = useSignal('');
  const { attempt, Failure } = useAttempt();
  const kind = className(component.classId);
  if (kind !== 'FeatureMap' && kind !== 'Mcl') return null;
  return (
    <>
      <p class="actions">
        <input
          aria-label="Name of the map's file"
          placeholder="floor.dxf"
          value={name.value}
          onInput={(event) => {
            name.value = event.currentTarget.value;
          }}
        />
        <button
          type="button"
          {...needs(`${kind}.LOAD_MAP`)}
          onClick={() => attempt(() => command(client, component, `${kind}.LOAD_MAP`, { name: name.value }))}
        >
          Load
        </button>
        {kind === 'FeatureMap' && (
          <button
            type="button"
            {...needs('FeatureMap.SAVE_MAP')}
            onClick={() => attempt(() => command(client, component, 'FeatureMap.SAVE_MAP', { name: name.value }))}
          >
            Save
          </button>
        )}
      </p>
      <Failure />
    </>
  );
}
