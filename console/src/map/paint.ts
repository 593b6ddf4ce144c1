// Draws a map: grid, walls, and for each robot its trail, path, particles, scan, objects, goal and hull.

import { valueName } from '../codec/catalogue';
import type { MapColours } from './colours';
import { eachEcho, pointType } from './echoes';
import { type PointBuffer, pixelOf } from './points';
import type { Hull, Localisation, Plan, RobotScene, Spline, Wall } from './scene';
import { gridStep, type Point, type Pose, placed, type Size, toScreen, toWorld, type View } from './transform';

export interface Layers {
  grid: boolean;
  map: boolean;
  trail: boolean;
  scan: boolean;
  path: boolean;
  particles: boolean;
  objects: boolean;
  walls: boolean;
  gps: boolean;
  goals: boolean;
}

export const allLayers: Layers = {
  grid: true,
  map: true,
  trail: true,
  scan: true,
  path: true,
  particles: false,
  objects: true,
  walls: true,
  gps: true,
  goals: true,
};

export interface Drawing {
  context: CanvasRenderingContext2D;
  points: PointBuffer;
  size: Size; // CSS pixels
  ratio: number; // device pixels a CSS pixel
  view: View;
  colours: MapColours;
}

const gridPixels = 60;
const staleTime = 3000; // ms
export const unknownDeviation = 50_000; // mm: from here on a position is a guess

export function paintMap(
  drawing: Drawing,
  scenes: RobotScene[],
  layers: Layers,
  now: number,
  background: Plan[],
): void {
  const { context, size, ratio, colours, points } = drawing;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.fillStyle = colours.ground;
  context.fillRect(0, 0, size.width, size.height);
  for (const plan of background) paintPlan(drawing, plan, true);
  if (layers.grid) paintGrid(drawing);
  points.resize(Math.round(size.width * ratio), Math.round(size.height * ratio));
  points.clear();
  if (layers.map) for (const { plan } of scenes) if (plan !== undefined) paintPlan(drawing, plan, false);
  for (const scene of scenes) {
    if (layers.walls) paintWalls(drawing, scene);
    const colour = robotColour(colours, scene.system);
    if (layers.trail) paintTrails(drawing, scene, colour);
    // Of one robot, a colour tells what a line is; of several, whose.
    if (layers.path) paintPaths(drawing, scene, scenes.length > 1 ? colour : colours.path);
    if (layers.particles) addLocalisation(drawing, scene.localisation);
    if (layers.scan) addScan(drawing, scene);
  }
  context.setTransform(1, 0, 0, 1, 0, 0);
  points.paint(context);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  for (const scene of scenes) {
    if (layers.path) {
      paintSplines(drawing, scene.splines, colours.pilot, 2);
      paintGoal(drawing, scene);
    }
    if (layers.objects) paintObjects(drawing, scene);
    if (layers.gps) paintGps(drawing, scene);
    if (layers.goals) paintRoute(drawing, scene);
    paintRobot(drawing, scene, now);
  }
  paintScale(drawing);
}

// Instances differ in their dashes, which everybody can tell apart.
const dashes = [[], [7, 4], [2, 3], [9, 3, 2, 3]];
const dashOf = (instance: number) => dashes[instance % dashes.length] ?? [];

function paintTrails(drawing: Drawing, { trail, otherTrails, system }: RobotScene, colour: string): void {
  const { context, view, size, colours } = drawing;
  paintLine(drawing, trail, colour, 1, 0.5);
  for (const [instance, other] of otherTrails) {
    context.setLineDash(dashes[1 + (instance % (dashes.length - 1))] ?? []);
    paintLine(drawing, other, colour, 1.5);
    context.setLineDash([]);
    const last = other.at(-1);
    if (last === undefined) continue;
    const { x, y } = toScreen(view, size, last);
    context.fillStyle = colours.text;
    context.font = '11px system-ui, sans-serif';
    context.textAlign = 'left';
    context.fillText(`Position ${system}/${instance}`, x + 6, y + 4);
  }
}

function paintPaths(drawing: Drawing, { paths }: RobotScene, colour: string): void {
  for (const [instance, splines] of paths) {
    drawing.context.setLineDash(dashOf(instance));
    paintSplines(drawing, splines, colour, 2);
    drawing.context.setLineDash([]);
  }
}

export function robotColour(colours: MapColours, system: number): string {
  return colours.robots[Math.max(0, system - 1) % colours.robots.length] ?? colours.text;
}

function paintGrid({ context, view, size, colours }: Drawing): void {
  const step = gridStep(view.scale, gridPixels);
  const corners = [
    [0, 0],
    [size.width, 0],
    [0, size.height],
    [size.width, size.height],
  ].map(([x = 0, y = 0]) => toWorld(view, size, { x, y }));
  const xs = corners.map(({ x }) => x);
  const ys = corners.map(({ y }) => y);
  const [south, north, west, east] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const line = (from: Point, to: Point, isAxis: boolean) => {
    const a = toScreen(view, size, from);
    const b = toScreen(view, size, to);
    context.beginPath();
    context.strokeStyle = isAxis ? colours.axis : colours.grid;
    context.lineWidth = 1;
    context.moveTo(a.x, a.y);
    context.lineTo(b.x, b.y);
    context.stroke();
  };
  for (let x = Math.ceil(south / step) * step; x <= north; x += step)
    line({ x, y: west }, { x, y: east }, Math.abs(x) < step / 2);
  for (let y = Math.ceil(west / step) * step; y <= east; y += step)
    line({ x: south, y }, { x: north, y }, Math.abs(y) < step / 2);
}

// A bar of known length in the corner.
function paintScale({ context, view, size, colours }: Drawing): void {
  const step = gridStep(view.scale, gridPixels);
  const width = step * view.scale;
  const x = 12;
  const y = size.height - 12;
  context.strokeStyle = colours.text;
  context.fillStyle = colours.text;
  context.lineWidth = 1.5;
  context.beginPath();
  context.moveTo(x, y - 5);
  context.lineTo(x, y);
  context.lineTo(x + width, y);
  context.lineTo(x + width, y - 5);
  context.stroke();
  context.font = '12px system-ui, sans-serif';
  context.textAlign = 'left';
  context.fillText(step >= 1e6 ? `${step / 1e6} km` : `${step / 1000} m`, x + 4, y - 5);
}

function paintPlan({ context, view, size, ratio }: Drawing, plan: Plan, smooth: boolean): void {
  const corner = toScreen(view, size, { x: plan.north, y: plan.west });
  const right = toScreen(view, size, { x: plan.north, y: plan.west + plan.cell });
  const down = toScreen(view, size, { x: plan.north - plan.cell, y: plan.west });
  context.save();
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.transform(right.x - corner.x, right.y - corner.y, down.x - corner.x, down.y - corner.y, corner.x, corner.y);
  context.imageSmoothingEnabled = smooth;
  context.drawImage(plan.picture, 0, 0);
  context.restore();
}

function paintWalls(drawing: Drawing, { walls, markedWall }: RobotScene): void {
  strokeWalls(drawing, walls, drawing.colours.wall, 1.5);
  if (markedWall !== undefined) strokeWalls(drawing, [markedWall], drawing.colours.goal, 4);
}

function strokeWalls({ context, view, size }: Drawing, walls: Wall[], colour: string, width: number): void {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  for (const { x, y, x2, y2 } of walls) {
    const a = toScreen(view, size, { x, y });
    const b = toScreen(view, size, { x: x2, y: y2 });
    context.moveTo(a.x, a.y);
    context.lineTo(b.x, b.y);
  }
  context.stroke();
}

function paintLine({ context, view, size }: Drawing, line: Point[], colour: string, width: number, alpha = 1): void {
  if (line.length < 2) return;
  context.strokeStyle = colour;
  context.globalAlpha = alpha;
  context.lineWidth = width;
  context.beginPath();
  for (const [i, point] of line.entries()) {
    const { x, y } = toScreen(view, size, point);
    if (i === 0) context.moveTo(x, y);
    else context.lineTo(x, y);
  }
  context.stroke();
  context.globalAlpha = 1;
}

function paintSplines(drawing: Drawing, splines: Spline[], colour: string, width: number): void {
  for (const spline of splines) paintLine(drawing, pointsOf(spline), colour, width);
}

// A spline as a chain of points: a straight line, or an arc about its centre.
export function pointsOf({ startPos, endPos, centerPos, radius, length }: Spline): Point[] {
  if (radius === 0 || length === 0) return [startPos, endPos];
  const begin = Math.atan2(startPos.y - centerPos.y, startPos.x - centerPos.x);
  const turn = length / radius;
  const pieces = Math.max(2, Math.ceil(Math.abs(turn) / 0.1));
  const distance = Math.hypot(startPos.x - centerPos.x, startPos.y - centerPos.y);
  return Array.from({ length: pieces + 1 }, (_, i) => {
    const angle = begin + (turn * i) / pieces;
    return { x: centerPos.x + distance * Math.cos(angle), y: centerPos.y + distance * Math.sin(angle) };
  });
}

function addPoints({ points, view, size, ratio }: Drawing, list: Point[], pixel: number, width: number): void {
  for (const point of list) {
    const { x, y } = toScreen(view, size, point);
    points.add(x * ratio, y * ratio, pixel, Math.round(width * ratio));
  }
}

function addLocalisation(drawing: Drawing, { samples, measurements, reflectors, lines }: Localisation): void {
  const { colours } = drawing;
  addPoints(drawing, samples, pixelOf(colours.particle), 2);
  addPoints(drawing, lines, pixelOf(colours.wall), 3);
  addPoints(drawing, measurements, pixelOf(colours.scan), 3);
  addPoints(drawing, reflectors, pixelOf(colours.reflector), 5);
}

function addScan({ points, view, size, ratio, colours }: Drawing, { scan }: RobotScene): void {
  if (scan === undefined) return;
  const plain = pixelOf(colours.scan);
  const reflector = pixelOf(colours.reflector);
  const moving = pixelOf(colours.moving);
  const width = Math.round(Math.min(4, Math.max(2, view.scale * 40)) * ratio);
  eachEcho(scan.points, (forward, right, type) => {
    const point = { x: forward, y: right };
    const { x, y } = toScreen(view, size, scan.isAbsolute ? point : placed(scan.pose, point));
    const isMoving = (type & pointType.classMask) === pointType.moving;
    const colour = (type & pointType.reflector) !== 0 ? reflector : isMoving ? moving : plain;
    points.add(x * ratio, y * ratio, colour, width);
  });
}

// The points that are not sent yet, joined in their order.
export function paintWaypoints(
  { context, view, size, colours }: Drawing,
  list: (Point & { backward: boolean })[],
): void {
  context.strokeStyle = colours.goal;
  context.fillStyle = colours.goal;
  context.lineWidth = 1.5;
  context.setLineDash([6, 4]);
  context.beginPath();
  for (const [i, point] of list.entries()) {
    const { x, y } = toScreen(view, size, point);
    if (i === 0) context.moveTo(x, y);
    else context.lineTo(x, y);
  }
  context.stroke();
  context.setLineDash([]);
  for (const point of list) {
    const { x, y } = toScreen(view, size, point);
    context.beginPath();
    context.arc(x, y, 4, 0, 2 * Math.PI);
    if (point.backward) context.stroke();
    else context.fill();
  }
}

function paintGoal({ context, view, size, colours }: Drawing, { goal, distanceToGoal }: RobotScene): void {
  if (goal === undefined || distanceToGoal <= 0) return;
  const { x, y } = toScreen(view, size, goal);
  context.strokeStyle = colours.goal;
  context.lineWidth = 2;
  context.beginPath();
  context.arc(x, y, 8, 0, 2 * Math.PI);
  context.moveTo(x - 12, y);
  context.lineTo(x + 12, y);
  context.moveTo(x, y - 12);
  context.lineTo(x, y + 12);
  context.stroke();
}

// A circle of its deviation, and a wedge of its heading.
function paintGps({ context, view, size, colours }: Drawing, { gps }: RobotScene): void {
  if (gps === undefined) return;
  const { x, y } = toScreen(view, size, gps.pose);
  const radius = Math.max(6, gps.deviation < unknownDeviation ? gps.deviation * view.scale : 6);
  context.strokeStyle = colours.gps;
  context.lineWidth = 1.5;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  const ahead = gps.pose.rho - view.up - Math.PI / 2;
  const half = Math.min(Math.PI, Math.max(0.03, gps.headingDeviation));
  const reach = Math.max(24, 1.5 * radius);
  context.moveTo(x, y);
  context.arc(x, y, reach, ahead - half, ahead + half);
  context.closePath();
  context.stroke();
}

// The goals of the view of Position: those that are passed are grey, the present one has the circle within which it
// counts as reached.
function paintRoute(drawing: Drawing, { goals, pose }: RobotScene): void {
  const list = goals.list.value;
  const { context, view, size, colours } = drawing;
  const index = goals.index.value;
  const goal = list[index];
  if (goal === undefined) return;
  paintLine(drawing, list.slice(0, index + 1), colours.stale, 1.5);
  if (pose !== undefined) paintLine(drawing, [pose, goal], colours.goal, 1.5);
  paintLine(drawing, list.slice(index), colours.goal, 1.5);
  const { x, y } = toScreen(view, size, goal);
  context.strokeStyle = colours.goal;
  context.lineWidth = 1.5;
  context.beginPath();
  context.arc(x, y, Math.max(4, goals.turnover.value * view.scale), 0, 2 * Math.PI);
  context.stroke();
}

function paintObjects({ context, view, size, colours }: Drawing, { objects }: RobotScene): void {
  context.strokeStyle = colours.object;
  context.fillStyle = colours.object;
  context.lineWidth = 1.5;
  context.font = '11px system-ui, sans-serif';
  context.textAlign = 'center';
  for (const { pose, length, width, id, type } of objects) {
    const half = { x: Math.max(length, 100) / 2, y: Math.max(width, 100) / 2 };
    outline(context, view, size, pose, { front: half.x, back: half.x, left: half.y, right: half.y, margin: 0 });
    context.stroke();
    const at = toScreen(view, size, pose);
    const name = type === 0 ? '' : valueName('ObjRecogObject.type', type);
    const above = Math.hypot(half.x, half.y) * view.scale; // and not on the points that it is made of
    context.fillText(`${id} ${name ?? ''}`, at.x, at.y - above - 3);
  }
}

function outline(context: CanvasRenderingContext2D, view: View, size: Size, pose: Pose, hull: Hull): void {
  const corners = [
    { x: hull.front, y: hull.right },
    { x: -hull.back, y: hull.right },
    { x: -hull.back, y: -hull.left },
    { x: hull.front, y: -hull.left },
  ].map((corner) => toScreen(view, size, placed(pose, corner)));
  context.beginPath();
  for (const [i, { x, y }] of corners.entries()) i === 0 ? context.moveTo(x, y) : context.lineTo(x, y);
  context.closePath();
}

const withMargin = ({ front, back, left, right, margin }: Hull): Hull => ({
  front: front + margin,
  back: back + margin,
  left: left + margin,
  right: right + margin,
  margin: 0,
});

// Hull, what its pilots keep free around it, heading and name; a circle of the deviation; grey when its position is old. A robot that would be a few
// pixels only is an arrow of constant size.
function paintRobot({ context, view, size, colours }: Drawing, scene: RobotScene, now: number): void {
  const { pose, hull, deviation, system } = scene;
  if (pose === undefined) return;
  const colour = now - scene.poseAt > staleTime ? colours.stale : robotColour(colours, system);
  const least = 14 / view.scale;
  const grow = Math.max(1, least / (hull.front + hull.back));
  const at = toScreen(view, size, pose);
  if (deviation * view.scale > 4 && deviation < unknownDeviation) {
    context.beginPath();
    context.arc(at.x, at.y, deviation * view.scale, 0, 2 * Math.PI);
    context.fillStyle = colour;
    context.globalAlpha = 0.12;
    context.fill();
    context.globalAlpha = 1;
  }
  const shown = {
    front: hull.front * grow,
    back: hull.back * grow,
    left: hull.left * grow,
    right: hull.right * grow,
    margin: 0,
  };
  outline(context, view, size, pose, shown);
  context.fillStyle = colour;
  context.globalAlpha = 0.35;
  context.fill();
  context.globalAlpha = 1;
  context.strokeStyle = colour;
  context.lineWidth = 1.5;
  context.stroke();
  if (hull.margin > 0 && grow === 1) {
    outline(context, view, size, pose, withMargin(hull));
    context.globalAlpha = 0.5;
    context.setLineDash([4, 4]);
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
  }
  const nose = toScreen(view, size, placed(pose, { x: shown.front, y: 0 }));
  context.beginPath();
  context.moveTo(at.x, at.y);
  context.lineTo(nose.x, nose.y);
  context.stroke();
  context.fillStyle = colours.text;
  context.font = '600 12px system-ui, sans-serif';
  context.textAlign = 'center';
  const name = deviation < unknownDeviation ? `${system}` : `${system}, position unknown`;
  context.fillText(name, at.x, at.y - Math.max(12, hull.left * grow * view.scale + 6));
}
