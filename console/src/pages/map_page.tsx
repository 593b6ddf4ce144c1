// The map of all robots, or of those that the address names.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { useConsole } from '../app/console';
import { route } from '../app/route';
import { actions, type Spot } from '../map/actions';
import { BackgroundMenu } from '../map/background_menu';
import { mapColours } from '../map/colours';
import { firstOf, followedOf, followRobot } from '../map/follow';
import { type Centre, MapCanvas, type MapModel, newMapModel, zoom } from '../map/map_canvas';
import { allLayers, type Layers, robotColour, unknownDeviation } from '../map/paint';
import { emptyScene, type RobotScene } from '../map/scene';
import { WaypointList } from '../map/waypoint_list';
import type { Robot } from '../model/fleet';
import { useAttempt } from '../ui/attempt';
import { Icon } from '../ui/icons';
import { stateWord } from '../ui/lamp';
import { needs } from '../ui/needs';
import { heading, metres } from '../ui/quantities';
import { pageVisible } from '../ui/use_stream';
import { MapFile } from '../views/map_view';

const robotsMax = 20; // with their scans and paths

export function MapPage() {
  const console = useConsole();
  const wanted = (route.value.options.get('robots') ?? '').split(',').filter((text) => text !== '');
  const robots = console.fleet.robots.value.filter((robot) =>
    wanted.length > 0 ? wanted.includes(`${robot.system}`) : firstOf(robot, 'Position') !== undefined,
  );
  if (wantedBefore !== undefined && wantedBefore !== wanted.join()) kept.isPlaced = false; // where others are
  wantedBefore = wanted.join();
  return <RobotMap robots={robots.slice(0, robotsMax)} />;
}

// Waypoints that are not sent, pictures, and what is in sight stay while other pages are visited.
const kept = newMapModel({ ...allLayers });
let wantedBefore: string | undefined;

function RobotMap({ robots }: { robots: Robot[] }) {
  const console = useConsole();
  const model = kept;
  const layers = useSignal<Layers>(model.layers);
  const tool = useSignal<string | undefined>(undefined);
  const report = useSignal('');
  const { attempt, Failure } = useAttempt();
  const centre = useSignal<Centre>(model.centre);
  const chosen = useSignal(model.followed);
  const selected = robots.find(({ system }) => system === chosen.value) ?? robots[0];
  model.followed = selected?.system;
  model.layers = layers.value;

  useEffect(() => {
    const shown = new Set(robots.map(({ system }) => system));
    for (const system of model.scenes.keys()) if (!shown.has(system)) model.scenes.delete(system);
    model.changed = true;
  }, [robots.map(({ system }) => system).join()]);

  useEffect(() => {
    const endTool = (event: KeyboardEvent) => {
      if (event.key === 'Escape' && !event.shiftKey) tool.value = undefined;
    };
    addEventListener('keydown', endTool);
    return () => removeEventListener('keydown', endTool);
  }, []);

  const action = actions.find(({ name }) => name === tool.value);
  const run = async (spot: Spot) => {
    const scene = selected === undefined ? undefined : model.scenes.get(selected.system);
    if (action === undefined || selected === undefined || scene === undefined) return;
    if (!action.repeats) tool.value = undefined;
    const pending = `${action.title} …`;
    report.value = pending;
    await attempt(async () => {
      const done = await action.run({ console, robot: selected, scene, waypoints: model.waypoints }, spot);
      report.value = typeof done === 'string' ? done : done.report;
      if (typeof done !== 'string') model.steps.add({ title: action.title, undo: done.undo });
    });
    if (report.value === pending) report.value = ''; // it failed
  };
  const step = model.steps.last.value;
  const undo = () =>
    attempt(async () => {
      report.value = await model.steps.undo();
    });
  const path = selected === undefined ? undefined : firstOf(selected, 'Path');
  const features = selected === undefined ? undefined : firstOf(selected, 'FeatureMap');
  // Once more: the next robot.
  const setCentre = (value: Centre) => {
    if (value !== 'world' && value === centre.value && robots.length > 1)
      chosen.value =
        robots[(robots.findIndex(({ system }) => system === selected?.system) + 1) % robots.length]?.system;
    centre.value = value;
    model.centre = value;
    model.changed = true;
  };
  model.moved = () => {
    centre.value = 'world';
  };
  return (
    <section class="map-page">
      {robots.map((robot) => (
        <Followed key={robot.system} robot={robot} model={model} />
      ))}
      <div class="tools">
        <h1>Map</h1>
        <label>
          Robot{' '}
          <select
            value={selected?.system}
            onChange={(event) => {
              chosen.value = Number(event.currentTarget.value);
              if (centre.value === 'world') setCentre('chase');
            }}
          >
            {robots.map(({ system }) => (
              <option key={system} value={system}>
                {system}
              </option>
            ))}
          </select>
        </label>
        <fieldset aria-label="Centre" class="tabs">
          {(['world', 'chase', 'robot'] as const).map((each) => (
            <button
              key={each}
              type="button"
              aria-pressed={centre.value === each}
              title={centreHints[each]}
              onClick={() => setCentre(each)}
            >
              {each}
            </button>
          ))}
        </fieldset>
        <label>
          Action{' '}
          <select
            value={tool.value ?? ''}
            {...needs('Pilot.SET_DESTINATION')}
            onChange={(event) => {
              tool.value = event.currentTarget.value || undefined;
            }}
          >
            <option value="">move the map</option>
            {actions
              .filter(({ component }) => selected !== undefined && (component === '' || firstOf(selected, component)))
              .map(({ name, title }) => (
                <option key={name} value={name}>
                  {title}
                </option>
              ))}
          </select>
        </label>
        {selected !== undefined && firstOf(selected, 'Pilot') !== undefined && (
          <button
            type="button"
            class="primary"
            aria-pressed={tool.value === 'goal'}
            {...needs('Pilot.SET_DESTINATION')}
            onClick={() => (tool.value = 'goal')}
          >
            Send robot here
          </button>
        )}
        {step !== undefined && (
          <button type="button" title={`Undo: ${step.title}`} {...needs('Pilot.SET_DESTINATION')} onClick={undo}>
            Undo
          </button>
        )}
        <span class="grow" />
        {features !== undefined && (
          <details class="menu">
            <summary>Walls</summary>
            <div>
              <MapFile component={features} />
            </div>
          </details>
        )}
        <BackgroundMenu model={model} />
        <LayerMenu layers={layers.value} change={(value) => (layers.value = value)} />
        <fieldset aria-label="Zoom" class="tabs">
          <button type="button" aria-label="Zoom in" onClick={() => zoom(model, 1.5)}>
            <Icon name="plus" />
          </button>
          <button type="button" aria-label="Zoom out" onClick={() => zoom(model, 1 / 1.5)}>
            <Icon name="minus" />
          </button>
          <button
            type="button"
            aria-label="Show all robots"
            onClick={() => {
              setCentre('world');
              model.isPlaced = false;
            }}
          >
            <Icon name="centre" />
          </button>
        </fieldset>
      </div>
      {action !== undefined && (
        <p class="notice">
          {action.title}: {action.hint}. <kbd>Esc</kbd> ends.
        </p>
      )}
      <div class="report">
        <p role="status">{report.value}</p>
        <Failure />
      </div>
      <div class="map-box">
        <MapCanvas
          model={model}
          label={`Map of ${robots.length} robots`}
          choose={action === undefined ? undefined : (spot) => void run(spot)}
        />
        <Positions model={model} robots={robots} />
        {path !== undefined && <WaypointList waypoints={model.waypoints} path={path} />}
      </div>
    </section>
  );
}

// Fills the scene of one robot.
function Followed({ robot, model }: { robot: Robot; model: MapModel }) {
  const console = useConsole();
  const visible = pageVisible.value;
  useEffect(() => {
    if (!visible) return;
    const scene = model.scenes.get(robot.system) ?? emptyScene(robot.system, console.goals.of(robot.system));
    model.scenes.set(robot.system, scene);
    return followRobot(console, robot, scene, () => {
      model.changed = true;
    });
  }, [followedOf(robot), visible]);
  return null;
}

const centreHints: Record<Centre, string> = {
  world: 'It stays where it is',
  chase: 'It follows the robot, north is up; once more: the next robot',
  robot: 'It follows and turns with the robot; once more: the next robot',
};

const deviationText = (deviation: number) => (deviation < unknownDeviation ? metres(deviation) : 'unknown');

function LayerMenu({ layers, change }: { layers: Layers; change: (layers: Layers) => void }) {
  return (
    <details class="menu">
      <summary>Layers</summary>
      <div>
        {(Object.keys(layers) as (keyof Layers)[]).map((name) => (
          <label key={name}>
            <input
              type="checkbox"
              checked={layers[name]}
              onChange={(event) => change({ ...layers, [name]: event.currentTarget.checked })}
            />{' '}
            {name}
          </label>
        ))}
      </div>
    </details>
  );
}

// The same in numbers, also for those who cannot see the map.
function Positions({ model, robots }: { model: MapModel; robots: Robot[] }) {
  const tick = useSignal(0);
  useEffect(() => {
    const timer = setInterval(() => ++tick.value, 500);
    return () => clearInterval(timer);
  }, []);
  void tick.value;
  return (
    <table class="positions">
      <thead>
        <tr>
          <th scope="col">Robot</th>
          <th scope="col">North</th>
          <th scope="col">East</th>
          <th scope="col">
            <abbr title="clockwise from north">Heading</abbr>
          </th>
          <th scope="col">
            <abbr title="standard deviation of the position">±</abbr>
          </th>
          <th scope="col">To goal</th>
        </tr>
      </thead>
      <tbody>
        {robots.map((robot) => (
          <PositionRow key={robot.system} robot={robot} scene={model.scenes.get(robot.system)} />
        ))}
      </tbody>
    </table>
  );
}

function PositionRow({ robot, scene }: { robot: Robot; scene: RobotScene | undefined }) {
  const { system } = robot;
  const name = (
    <th scope="row">
      <span class="swatch" style={{ background: robotColour(mapColours(), system) }} /> {system}
    </th>
  );
  const pose = scene?.pose;
  if (scene === undefined || pose === undefined) {
    const position = firstOf(robot, 'Position');
    return (
      <tr>
        {name}
        <td colSpan={5} class="faint">
          {position === undefined ? 'it has no Position' : `Position: ${stateWord(position.state.value)}`}
        </td>
      </tr>
    );
  }
  return (
    <tr>
      {name}
      <td>{metres(pose.x)}</td>
      <td>{metres(pose.y)}</td>
      <td>{heading(pose.rho)}</td>
      <td>{deviationText(scene.deviation)}</td>
      <td>{scene.distanceToGoal > 0 ? metres(scene.distanceToGoal) : '–'}</td>
    </tr>
  );
}
