// Fills the scene of a robot from the data of its components: one subscription for the first of a class that is on, and
// for each position, path and pilot.

import type { Console } from '../app/console';
import { classId, decodeData, decodeStruct, valueName } from '../codec/catalogue';
import type { GpsData, MclDataPoint } from '../codec/messages';
import type { Elements } from '../codec/views';
import { command } from '../model/commands';
import type { Component, Fleet, Robot } from '../model/fleet';
import type { Client } from '../tims/client';
import { decodeHeader, headerSize } from '../tims/header';
import type { FollowPosition } from './goals';
import { planOf } from './plan';
import {
  type DetectedObject,
  defaultHull,
  type Localisation,
  movedTo,
  otherMovedTo,
  type RobotScene,
  type Spline,
  type Wall,
} from './scene';
import type { Pose } from './transform';

interface PositionData {
  pos: Pose;
  var: Pose;
}

interface ScanData {
  refPos: Pose;
  points: Elements;
}

interface PilotData {
  dest: Pose;
  distanceToDest: number;
  splines: Spline[];
}

interface ObjectsData {
  refPos: Pose;
  objects: { objectId: number; type: number; pos: Pose; dim: { x: number; y: number } }[];
}

type Take = (scene: RobotScene, data: never, now: number, instance: number) => void;

const periods = { fast: 66, normal: 200, slow: 1000 }; // ms

interface Source {
  name: string;
  period: number;
  take: Take;
  takeOther?: Take; // of its other instances
  elements?: boolean;
}

const sources: Source[] = [
  {
    name: 'Position',
    period: periods.fast,
    take: takePosition as Take,
    takeOther: takeOtherPosition as Take,
  },
  { name: 'Scan2d', period: periods.fast, take: takeScan as Take, elements: true },
  { name: 'Pilot', period: periods.normal, take: takePilot as Take, takeOther: takePilot as Take },
  { name: 'Path', period: periods.slow, take: takePath as Take, takeOther: takePath as Take },
  { name: 'Mcl', period: periods.normal, take: takeMcl as Take },
  { name: 'ObjRecog', period: periods.normal, take: takeObjects as Take },
  { name: 'Gps', period: periods.normal, take: takeGps as Take },
  { name: 'FeatureMap', period: periods.slow, take: takeFeatures as Take },
];

// Returns what ends it. `changed` is called after every change.
export function followRobot(console: Console, robot: Robot, scene: RobotScene, changed: () => void): () => void {
  const ends: (() => void)[] = [];
  const follow = ({ address, classId: id, instance }: Component, take: Take, period: number, elements = false) =>
    console.client.subscribe(address, period, ({ message, at }) => {
      const header = decodeHeader(message);
      if (header === undefined) return;
      take(scene, decodeData(id, message.subarray(headerSize), header.flags, { elements }) as never, at, instance);
      changed();
    });
  for (const { name, period, take, takeOther, elements } of sources) {
    const first = firstOf(robot, name);
    if (first === undefined) continue;
    ends.push(follow(first, take, period, elements));
    if (takeOther === undefined) continue;
    for (const other of robot.components)
      if (other.classId === first.classId && other !== first) ends.push(follow(other, takeOther, periods.normal));
  }
  void askHull(console, robot, scene).then(changed, () => {});
  ends.push(followPlan(console, robot, scene, changed));
  return () => {
    for (const end of ends) end();
  };
}

// Tells apart what of a robot is followed: when it changes, followRobot() begins anew.
export function followedOf(robot: Robot): string {
  const firsts = sources.map(({ name }) => firstOf(robot, name)?.address);
  const others = robot.components.map(({ address }) => address);
  return [...firsts, ...others].join();
}

export function firstOf(robot: Robot, className: string): Component | undefined {
  const id = classId(className);
  const all = robot.components.filter((component) => component.classId === id);
  return all.find(({ state }) => state.value === 'on') ?? all[0];
}

// The Position of a robot that leads it to its goals: also while nobody looks.
export function followPosition(client: Client, fleet: Fleet): FollowPosition {
  return (system, take) => {
    const robot = fleet.robot(system);
    const position = robot === undefined ? undefined : firstOf(robot, 'Position');
    if (position === undefined) return () => {};
    return client.subscribe(position.address, periods.normal, ({ message }) => {
      const header = decodeHeader(message);
      if (header === undefined) return;
      const data = decodeData(position.classId, message.subarray(headerSize), header.flags);
      take((data as unknown as PositionData).pos);
    });
  };
}

function takePosition(scene: RobotScene, { pos, var: deviation }: PositionData, now: number): void {
  movedTo(scene, pos, Math.max(deviation.x, deviation.y), now);
}

function takeOtherPosition(scene: RobotScene, { pos }: PositionData, _now: number, instance: number): void {
  otherMovedTo(scene, instance, pos);
}

function takeScan(scene: RobotScene, { refPos, points }: ScanData): void {
  if (scene.pose === undefined) return;
  const isAbsolute = refPos.x !== 0 || refPos.y !== 0 || refPos.rho !== 0;
  scene.scan = { pose: scene.pose, isAbsolute, points };
}

// A pilot that is on without a way to drive leaves that of the one that drives.
function takePilot(scene: RobotScene, data: PilotData, _now: number, instance: number): void {
  const { dest, distanceToDest, splines } = data;
  if (splines.length > 0) scene.pilot = instance;
  if (scene.pilot !== undefined && scene.pilot !== instance) return;
  scene.goal = dest;
  scene.distanceToGoal = distanceToDest;
  scene.splines = splines;
}

function takePath(scene: RobotScene, { splines }: { splines: Spline[] }, _now: number, instance: number): void {
  scene.paths.set(instance, splines);
}

function takeMcl(scene: RobotScene, { points }: { points: MclDataPoint[] }): void {
  scene.localisation = localisationOf(points);
}

export function localisationOf(points: MclDataPoint[]): Localisation {
  const of = (kind: string) => points.filter(({ type }) => valueName('MclDataPoint.type', type) === kind);
  return { samples: of('sample'), measurements: of('measurement'), reflectors: of('reflector'), lines: of('line') };
}

function takeObjects(scene: RobotScene, { objects }: ObjectsData): void {
  scene.objects = objects.map(
    ({ objectId, type, pos, dim }): DetectedObject => ({
      id: objectId,
      type,
      pose: pos,
      length: dim.x,
      width: dim.y,
    }),
  );
}

function takeGps(scene: RobotScene, { mode, pos, var: deviation }: GpsData): void {
  scene.gps =
    mode === 0
      ? undefined
      : { pose: pos, deviation: Math.max(deviation.x, deviation.y), headingDeviation: deviation.rho };
}

function takeFeatures(scene: RobotScene, { features }: { features: RobotScene['walls'] }): void {
  scene.walls = features;
  const marked = scene.markedWall;
  const isSame = (wall: Wall) =>
    wall.x === marked?.x && wall.y === marked.y && wall.x2 === marked.x2 && wall.y2 === marked.y2;
  scene.markedWall = features.find(isSame); // none when it was deleted or moved
}

// The map is asked for when its Path goes on, and again from time to time: it may have another one.
function followPlan(console: Console, robot: Robot, scene: RobotScene, changed: () => void): () => void {
  const path = firstOf(robot, 'Path');
  if (path === undefined) return () => {};
  const ask = async () => {
    if (path.state.value !== 'on' || document.hidden) return;
    scene.plan = await planOf(console, path);
    changed();
  };
  const end = path.state.subscribe(() => void ask().catch(() => {}));
  const timer = setInterval(() => void ask().catch(() => {}), planPeriod);
  return () => {
    end();
    clearInterval(timer);
  };
}

const planPeriod = 30_000; // ms

async function askHull(console: Console, robot: Robot, scene: RobotScene): Promise<void> {
  const chassis = firstOf(robot, 'Chassis');
  if (chassis === undefined) return;
  const answer = await command(console.client, chassis, 'Chassis.GET_PARAMETER');
  const hull = decodeStruct('ChassisParamData', answer.body, answer.flags);
  scene.hull = {
    front: hull.boundaryFront || defaultHull.front,
    back: hull.boundaryBack || defaultHull.back,
    left: hull.boundaryLeft || defaultHull.left,
    right: hull.boundaryRight || defaultHull.right,
    margin: hull.safetyMargin || 0,
  };
}
