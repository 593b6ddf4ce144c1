// What can be done at a place of the map: the commands of the original's map view.

import type { Console } from '../app/console';
import { decodeData } from '../codec/catalogue';
import type { FeatureMapDataPoint, ObjRecogObject, WorldData } from '../codec/messages';
import { command } from '../model/commands';
import type { Component, Robot } from '../model/fleet';
import { types, wordBody } from '../tims/header';
import { heading, metres } from '../ui/quantities';
import { firstOf } from './follow';
import type { RobotScene, Wall } from './scene';
import type { Step } from './steps';
import { distanceToLine, headingTo, type Point, type Pose, placed } from './transform';
import type { Waypoints } from './waypoints';

// Where the pointer was pressed, with the heading to where it was released.
export interface Spot extends Pose {
  end: Point;
}

export interface Work {
  console: Console;
  robot: Robot;
  scene: RobotScene;
  waypoints: Waypoints;
}

export interface MapAction {
  name: string;
  title: string;
  hint: string;
  component: string; // class
  repeats?: boolean; // it stays chosen
  run: (work: Work, spot: Spot) => Promise<string | Done>; // a sentence
}

// What can be taken back.
export interface Done {
  report: string;
  undo: Step['undo'];
}

const goalSpeed = 10000; // mm/s: as fast as the pilot permits
const onTime = 20000; // ms
const localiseTime = 10000; // ms
const sureDeviation = 500; // mm
const obstacleRadius = 250; // mm
const obstacleHeight = 1000;

// The distance and the direction from one place to another.
export function measured({ x, y, rho, end }: Spot): string {
  return `${metres(Math.hypot(end.x - x, end.y - y))}, ${heading(rho)}`;
}

const turnHint = 'press at the place, and drag to where it shall look';
const lineHint = 'press at one end, and drag to the other';

export const actions: MapAction[] = [
  {
    name: 'measure',
    title: 'Measure',
    hint: 'press at one place, and drag to the other',
    component: '',
    repeats: true,
    run: async (_, spot) => measured(spot),
  },
  { name: 'goal', title: 'Send robot here', hint: turnHint, component: 'Pilot', run: sendRobot },
  { name: 'position', title: 'Robot is here', hint: turnHint, component: 'Position', run: setPosition },
  {
    name: 'path-goal',
    title: 'Plan a path to here',
    hint: turnHint,
    component: 'Path',
    run: planPath,
  },
  ...waypointActions(),
  ...[0, 1, 2].map((layer) => wallAction(layer)),
  {
    name: 'wall-mark',
    title: 'Mark a wall',
    hint: 'press at a wall to see which one it is; elsewhere: none is marked',
    component: 'FeatureMap',
    repeats: true,
    run: markWall,
  },
  { name: 'wall-delete', title: 'Delete a wall', hint: 'press at the wall', component: 'FeatureMap', run: deleteWall },
  {
    name: 'wall-move',
    title: 'Move a wall',
    hint: 'press at the wall, and drag it to its place',
    component: 'FeatureMap',
    run: moveWall,
  },
  {
    name: 'estimate',
    title: 'An object is here',
    hint: turnHint,
    component: 'ObjRecog',
    run: setEstimate,
  },
  { name: 'place', title: 'Place the robot (simulation)', hint: turnHint, component: 'World', run: placeRobot },
  {
    name: 'obstacle',
    title: 'Put an obstacle (simulation)',
    hint: 'press at the place',
    component: 'World',
    run: putObstacle,
  },
];

function waypointActions(): MapAction[] {
  const action = (backward: boolean): MapAction => ({
    name: backward ? 'waypoint-back' : 'waypoint',
    title: backward ? 'Waypoint, backward' : 'Waypoint, forward',
    hint: 'press at each place; the list beside the map sends them',
    component: 'Path',
    repeats: true,
    run: async ({ waypoints }, { x, y }) => {
      waypoints.add({ x: Math.round(x), y: Math.round(y), backward });
      return `${waypoints.list.value.length} waypoints`;
    },
  });
  return [action(false), action(true)];
}

function wallAction(layer: number): MapAction {
  return {
    name: `wall-${layer}`,
    title: `Add a wall, layer ${layer}`,
    hint: lineHint,
    component: 'FeatureMap',
    run: async ({ console, robot }, spot) => {
      const map = need(robot, 'FeatureMap');
      const feature = wall(spot, spot.end, layer);
      await command(console.client, map, 'FeatureMap.ADD_LINE', { feature });
      return {
        report: `The wall is in the map${saveHint}`,
        undo: async () => {
          const featureNumTemp = await numberOf(console, map, feature);
          await command(console.client, map, 'FeatureMap.DELETE_LINE', { featureNumTemp });
          return 'The wall is out of the map again';
        },
      };
    },
  };
}

const pose3d = ({ x, y, rho }: Pose) => ({
  x: Math.round(x),
  y: Math.round(y),
  z: 0,
  phi: 0,
  psi: 0,
  rho: rho < 0 ? rho + 2 * Math.PI : rho,
});

const place = ({ x, y }: Point) => `${(x / 1000).toFixed(2)} m north, ${(y / 1000).toFixed(2)} m east`;

function need(robot: Robot, name: string) {
  const component = firstOf(robot, name);
  if (component === undefined) throw new Error(`robot ${robot.system} has no ${name}`);
  return component;
}

// As the original: to a goal behind the robot, in which it looks the same way, it backs.
export function goalSpeedFor(robot: Pose | undefined, goal: Pose): number {
  if (robot === undefined) return goalSpeed;
  const turnTo = (heading: number) =>
    Math.abs(Math.atan2(Math.sin(heading - robot.rho), Math.cos(heading - robot.rho)));
  const isBehind = turnTo(headingTo(robot, goal)) > behind;
  return isBehind && turnTo(goal.rho) < sameWay ? -goalSpeed : goalSpeed;
}

const behind = (2 / 3) * Math.PI;
const sameWay = Math.PI / 2;

// A pilot drives only when the chassis obeys it, when both are on, and when the robot is sure where it is.
async function sendRobot({ console, robot, scene }: Work, pose: Spot): Promise<string> {
  const driver = need(robot, 'Pilot');
  const base = need(robot, 'Chassis');
  await localise(console, robot);
  await console.leases.during(robot.system, async () => {
    if (base.state.value !== 'on') await console.fleet.turn(base, true);
    await command(console.client, base, 'Chassis.SET_ACTIVE_PILOT', { activePilot: driver.address });
    if (driver.state.value !== 'on') await console.fleet.turn(driver, true);
    const speed = goalSpeedFor(scene.pose, pose);
    await command(console.client, driver, 'Pilot.SET_DESTINATION', { pos: pose3d(pose), speed }, onTime);
  });
  return `Robot ${robot.system} drives to ${place(pose)}`;
}

// The robot's Path looks for a way; who drives it is another matter.
async function planPath({ console, robot, scene }: Work, spot: Spot): Promise<string> {
  const { x, y, rho } = pose3d(spot);
  const speed = goalSpeedFor(scene.pose, spot);
  await command(console.client, need(robot, 'Path'), 'Path.SET_DESTINATION', { pos: { x, y, rho }, speed, layer: 0 });
  return `A path to ${place(spot)} is planned`;
}

async function localise(console: Console, robot: Robot): Promise<void> {
  const mcl = firstOf(robot, 'Mcl');
  if (mcl !== undefined && mcl.state.value !== 'on') await console.fleet.turn(mcl, true);
  const position = need(robot, 'Position');
  for (const deadline = performance.now() + localiseTime; ; ) {
    const answer = await console.client.call(position.address, types.getData, wordBody(0));
    const data =
      answer.type === types.data
        ? (decodeData(position.classId, answer.body, answer.flags) as unknown as Uncertain)
        : undefined;
    if (data !== undefined && Math.max(data.var.x, data.var.y) < sureDeviation) return;
    if (performance.now() > deadline)
      throw new Error(`robot ${robot.system} is not sure where it is: set its position, or drive it about by hand`);
    await new Promise((resolve) => setTimeout(resolve, 250));
  }
}

type Uncertain = { var: { x: number; y: number } } & Record<string, unknown>;

async function setPosition({ console, robot, scene }: Work, pose: Spot): Promise<string | Done> {
  const component = need(robot, 'Position');
  const deviation = { x: 300, y: 300, z: 0, phi: 0, psi: 0, rho: 0.2 };
  const update = (pos: Pose) =>
    command(console.client, component, 'Position.UPDATE', { recordingTime: 0, pos: pose3d(pos), var: deviation });
  const before = scene.pose;
  await update(pose);
  const report = `The position of robot ${robot.system} is ${place(pose)}`;
  if (before === undefined) return report;
  return {
    report,
    undo: async () => {
      const was = withMotion(before, pose, scene.pose ?? pose);
      await update(was);
      return `The position of robot ${robot.system} is ${place(was)} again`;
    },
  };
}

// Where a robot would be that was believed to be at `before` and has driven from one place to the other meanwhile.
export function withMotion(before: Pose, from: Pose, to: Pose): Pose {
  const turn = before.rho - from.rho;
  const driven = placed({ x: 0, y: 0, rho: turn }, { x: to.x - from.x, y: to.y - from.y });
  const rho = before.rho + to.rho - from.rho;
  return { x: before.x + driven.x, y: before.y + driven.y, rho: Math.atan2(Math.sin(rho), Math.cos(rho)) };
}

async function putObstacle({ console, robot }: Work, { x, y }: Spot): Promise<string> {
  const component = need(robot, 'World');
  await command(console.client, component, 'World.PUT', {
    id: 0,
    pos: { x: Math.round(x), y: Math.round(y) },
    radius: obstacleRadius,
    height: obstacleHeight,
  });
  return 'An obstacle is there';
}

// The world's robot of a system is the one that its devices belong to: the first.
async function placeRobot({ console, robot }: Work, { x, y, rho }: Spot): Promise<string> {
  const component = need(robot, 'World');
  const answer = await console.client.call(component.address, types.getData, wordBody(0));
  const data = decodeData(component.classId, answer.body, answer.flags) as unknown as WorldData;
  const placedRobot = data.things.find(({ kind }) => kind === robotThing);
  if (placedRobot === undefined) throw new Error('no robot is in this world');
  const pos = { x: Math.round(x), y: Math.round(y), rho };
  await command(console.client, component, 'World.PLACE', { robot: placedRobot.name, pos });
  return `${placedRobot.name} stands at ${place({ x, y })}`;
}

async function setEstimate({ console, robot }: Work, pose: Spot): Promise<string> {
  const component = need(robot, 'ObjRecog');
  const object = { objectId: 0, pos: pose3d(pose) } as ObjRecogObject;
  await command(console.client, component, 'ObjRecog.SET_ESTIMATE', { objects: [object] });
  return `An object is expected at ${place(pose)}`;
}

// --- walls of a feature map

function wall(from: Point, to: Point, layer: number): FeatureMapDataPoint {
  const length = Math.hypot(to.x - from.x, to.y - from.y);
  if (length < wallMin) throw new Error('this wall is too short: drag to its other end');
  const rho = headingTo(from, to);
  return {
    x: from.x,
    y: from.y,
    x2: to.x,
    y2: to.y,
    l: length,
    rho,
    sin: Math.sin(rho),
    cos: Math.cos(rho),
    layer,
    type: lineFeature,
  };
}

async function markWall({ scene }: Work, at: Spot): Promise<string> {
  scene.markedWall = undefined;
  const number = nearestWall(scene, at);
  const marked = scene.walls[number];
  scene.markedWall = marked;
  if (marked === undefined) return '';
  const { x, y, x2, y2, layer } = marked;
  const length = metres(Math.hypot(x2 - x, y2 - y));
  return `Wall ${number} of ${scene.walls.length}, layer ${layer}: ${length} from ${place({ x, y })} to ${place({ x: x2, y: y2 })}`;
}

function nearestWall({ walls }: RobotScene, at: Point): number {
  const distances = walls.map(({ x, y, x2, y2 }) => distanceToLine(at, { x, y }, { x: x2, y: y2 }));
  const least = Math.min(...distances);
  if (!(least < reach)) throw new Error('no wall of the map is there');
  return distances.indexOf(least);
}

async function deleteWall({ console, robot, scene }: Work, at: Spot): Promise<Done> {
  const map = need(robot, 'FeatureMap');
  const featureNumTemp = nearestWall(scene, at);
  const old = scene.walls[featureNumTemp]!;
  await command(console.client, map, 'FeatureMap.DELETE_LINE', { featureNumTemp });
  return {
    report: `The wall is deleted${saveHint}`,
    undo: async () => {
      await command(console.client, map, 'FeatureMap.ADD_LINE', { feature: wallAgain(old) });
      return 'The wall is in the map again';
    },
  };
}

async function moveWall({ console, robot, scene }: Work, at: Spot): Promise<Done> {
  const map = need(robot, 'FeatureMap');
  const featureNumTemp = nearestWall(scene, at);
  const old = scene.walls[featureNumTemp];
  if (old === undefined) throw new Error('no wall of the map is there');
  const [dx, dy] = [at.end.x - at.x, at.end.y - at.y];
  const feature = wall({ x: old.x + dx, y: old.y + dy }, { x: old.x2 + dx, y: old.y2 + dy }, old.layer);
  await command(console.client, map, 'FeatureMap.DISPLACE_LINE', { feature, featureNumTemp });
  return {
    report: `The wall is moved${saveHint}`,
    undo: async () => {
      const number = await numberOf(console, map, feature);
      await command(console.client, map, 'FeatureMap.DISPLACE_LINE', {
        feature: wallAgain(old),
        featureNumTemp: number,
      });
      return 'The wall is where it was';
    },
  };
}

// A line as the map had it.
const wallAgain = ({ x, y, x2, y2, layer }: Wall) => wall({ x, y }, { x: x2, y: y2 }, layer);

// The number of a wall in the map as it is now: numbers change when others are added and deleted.
async function numberOf({ client }: Console, map: Component, wanted: Wall): Promise<number> {
  const answer = await client.call(map.address, types.getData, wordBody(0));
  if (answer.type !== types.data) throw new Error('the map does not answer');
  const { features } = decodeData(map.classId, answer.body, answer.flags) as unknown as { features: Wall[] };
  const number = features.findIndex(({ x, y, x2, y2 }) => {
    const isSame = (from: Point, to: Point) =>
      Math.hypot(from.x - wanted.x, from.y - wanted.y) < sameWall &&
      Math.hypot(to.x - wanted.x2, to.y - wanted.y2) < sameWall;
    return isSame({ x, y }, { x: x2, y: y2 }) || isSame({ x: x2, y: y2 }, { x, y });
  });
  if (number < 0) throw new Error('this wall is not in the map any more');
  return number;
}

const saveHint = '; keep it by Walls, Save';
const sameWall = 1; // mm

const wallMin = 50; // mm
const reach = 500;
const lineFeature = 10;
const robotThing = 0;
