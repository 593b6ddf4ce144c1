// What can be done at a place of the map: the commands of the original's map view.

import type { Console } from '../app/console';
import { nameOf } from '../app/console';
import { decodeData, encodeMessage } from '../codec/catalogue';
import type { Robot } from '../model/fleet';
import { types, wordBody } from '../tims/header';
import { firstOf } from './follow';
import type { Pose } from './transform';

export interface MapAction {
  name: string;
  title: string;
  component: string; // class
  run: (console: Console, robot: Robot, pose: Pose) => Promise<string>;
}

// Types of messages, by class.
const pilot = { setDestination: 21 };
const chassis = { setActivePilot: 23 };
const position = { update: 21 };
const world = { put: 22 };

const goalSpeed = 10000; // mm/s: as fast as the pilot permits
const onTime = 20000; // ms
const localiseTime = 10000; // ms
const sureDeviation = 500; // mm
const obstacleRadius = 250; // mm
const obstacleHeight = 1000;

export const actions: MapAction[] = [
  { name: 'goal', title: 'Send robot here', component: 'Pilot', run: sendRobot },
  { name: 'position', title: 'Robot is here', component: 'Position', run: setPosition },
  { name: 'obstacle', title: 'Put an obstacle (simulation)', component: 'World', run: putObstacle },
];

async function command(
  console: Console,
  address: number,
  classNumber: number,
  type: number,
  value: object,
): Promise<void> {
  const answer = await console.client.call(address, type, encodeMessage(classNumber, type, value), onTime);
  if (answer.type >= 0 || answer.type < types.notAvailable) return;
  const reason = new TextDecoder().decode(answer.body);
  throw new Error(
    `${nameOf(console, address)}: ${answer.type === types.notAvailable ? 'it is not there' : reason || 'it refuses'}`,
  );
}

const pose3d = ({ x, y, rho }: Pose) => ({
  x: Math.round(x),
  y: Math.round(y),
  z: 0,
  phi: 0,
  psi: 0,
  rho: rho < 0 ? rho + 2 * Math.PI : rho,
});

const place = ({ x, y }: Pose) => `${(x / 1000).toFixed(2)} m north, ${(y / 1000).toFixed(2)} m east`;

function need(robot: Robot, name: string) {
  const component = firstOf(robot, name);
  if (component === undefined) throw new Error(`robot ${robot.system} has no ${name}`);
  return component;
}

// A pilot drives only when the chassis obeys it, when both are on, and when the robot is sure where it is.
async function sendRobot(console: Console, robot: Robot, pose: Pose): Promise<string> {
  const driver = need(robot, 'Pilot');
  const base = need(robot, 'Chassis');
  await localise(console, robot);
  if (base.state.value !== 'on') await console.fleet.turn(base, true);
  await command(console, base.address, base.classId, chassis.setActivePilot, { activePilot: driver.address });
  if (driver.state.value !== 'on') await console.fleet.turn(driver, true);
  await command(console, driver.address, driver.classId, pilot.setDestination, { pos: pose3d(pose), speed: goalSpeed });
  return `Robot ${robot.system} drives to ${place(pose)}`;
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

async function setPosition(console: Console, robot: Robot, pose: Pose): Promise<string> {
  const component = need(robot, 'Position');
  const deviation = { x: 300, y: 300, z: 0, phi: 0, psi: 0, rho: 0.2 };
  await command(console, component.address, component.classId, position.update, {
    recordingTime: 0,
    pos: pose3d(pose),
    var: deviation,
  });
  return `The position of robot ${robot.system} is ${place(pose)}`;
}

async function putObstacle(console: Console, robot: Robot, { x, y }: Pose): Promise<string> {
  const component = need(robot, 'World');
  await command(console, component.address, component.classId, world.put, {
    id: 0,
    pos: { x: Math.round(x), y: Math.round(y) },
    radius: obstacleRadius,
    height: obstacleHeight,
  });
  return 'An obstacle is there';
}
