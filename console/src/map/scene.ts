// What a map shows of one robot: the newest data of its components, and where it has been.

import type { Elements } from '../codec/views';
import { Goals } from './goals';
import type { Point, Pose } from './transform';

export interface ScanPoints {
  pose: Pose; // of the robot when the scan arrived
  isAbsolute: boolean; // the points are in the world's frame already
  points: Elements;
}

export interface Spline {
  startPos: Pose;
  endPos: Pose;
  centerPos: Pose;
  length: number;
  radius: number; // 0: a straight line
  vMax: number;
}

export interface Hull {
  front: number;
  back: number;
  left: number;
  right: number;
  margin: number;
}

export interface DetectedObject {
  id: number;
  type: number;
  pose: Pose;
  length: number;
  width: number;
}

// The map that a robot plans in, as a picture with north up.
export interface Plan {
  picture: CanvasImageSource;
  north: number; // its upper edge, mm
  west: number; // its left edge
  cell: number; // mm a pixel
}

// Where a satellite receiver says that the robot is.
export interface GpsFix {
  pose: Pose;
  deviation: number; // mm
  headingDeviation: number; // rad
}

export interface RobotScene {
  system: number;
  pose: Pose | undefined;
  deviation: number; // mm, of the position
  poseAt: number; // performance.now()
  trail: Pose[];
  otherTrails: Map<number, Pose[]>; // of the robot's other instances of Position, by instance
  hull: Hull;
  scan: ScanPoints | undefined;
  paths: Map<number, Spline[]>; // by instance of Path
  splines: Spline[]; // of the pilot that drives
  pilot: number | undefined; // its instance
  goal: Pose | undefined;
  distanceToGoal: number; // mm
  localisation: Localisation;
  objects: DetectedObject[];
  plan: Plan | undefined;
  goals: Goals;
  gps: GpsFix | undefined;
  walls: Wall[];
  markedWall: Wall | undefined;
}

// What a localisation believes, and what it believes it for.
export interface Localisation {
  samples: Point[];
  measurements: Point[];
  reflectors: Point[];
  lines: Point[];
}

// A line of a feature map.
export interface Wall {
  x: number;
  y: number;
  x2: number;
  y2: number;
  layer: number;
}

export const defaultHull: Hull = { front: 300, back: 300, left: 250, right: 250, margin: 0 };

const trailMax = 2000;
const trailStep = 50; // mm

export function emptyScene(system: number, goals = new Goals()): RobotScene {
  return {
    system,
    pose: undefined,
    deviation: 0,
    poseAt: 0,
    trail: [],
    otherTrails: new Map(),
    hull: defaultHull,
    scan: undefined,
    paths: new Map(),
    splines: [],
    pilot: undefined,
    goal: undefined,
    distanceToGoal: 0,
    localisation: { samples: [], measurements: [], reflectors: [], lines: [] },
    objects: [],
    plan: undefined,
    walls: [],
    markedWall: undefined,
    goals,
    gps: undefined,
  };
}

export function movedTo(scene: RobotScene, pose: Pose, deviation: number, now: number): void {
  scene.pose = pose;
  scene.deviation = deviation;
  scene.poseAt = now;
  lengthen(scene.trail, pose);
}

// What another instance of Position believes.
export function otherMovedTo({ otherTrails }: RobotScene, instance: number, pose: Pose): void {
  const trail = otherTrails.get(instance) ?? [];
  otherTrails.set(instance, trail);
  lengthen(trail, pose);
}

function lengthen(trail: Pose[], pose: Pose): void {
  const last = trail.at(-1);
  if (last !== undefined && Math.hypot(pose.x - last.x, pose.y - last.y) < trailStep) return;
  trail.push(pose);
  if (trail.length > trailMax) trail.splice(0, trail.length - trailMax);
}
