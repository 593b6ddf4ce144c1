// Driving by hand: the console is the joystick of a pilot that has one among its parameters.

import type { Console } from '../app/console';
import { widthsOf } from '../app/console';
import { classId, decodeMessage } from '../codec/catalogue';
import type { ParameterList } from '../codec/messages';
import { firstOf } from '../map/follow';
import { command, noPilot, stopCommand } from '../model/commands';
import type { Component, Robot } from '../model/fleet';
import { addressOf, classes } from '../tims/address';
import { types } from '../tims/header';

export interface StickPilot {
  pilot: Component;
  joystick: number; // the address that it listens to
}

export const pilotsOf = (robot: Robot) => robot.components.filter(({ classId: id }) => id === classId('Pilot'));

export interface Pilots {
  byStick: StickPilot[];
  byThemselves: Component[];
  silent: Component[]; // they have not answered, this time
}

// The pilots of a robot by what drives them. One that does not answer hides none of the others.
export async function askPilots(console: Console, robot: Robot): Promise<Pilots> {
  const pilots: Pilots = { byStick: [], byThemselves: [], silent: [] };
  const all = pilotsOf(robot);
  const sticks = await Promise.all(all.map((pilot) => stickOf(console, robot, pilot).catch(() => null)));
  for (const [i, pilot] of all.entries()) {
    const joystick = sticks[i];
    if (joystick === null) pilots.silent.push(pilot);
    else if (joystick === undefined) pilots.byThemselves.push(pilot);
    else pilots.byStick.push({ pilot, joystick });
  }
  return pilots;
}

// Undefined: it listens to none.
async function stickOf(console: Console, robot: Robot, pilot: Component): Promise<number | undefined> {
  const answer = await console.client.call(pilot.address, types.getParam);
  if (answer.type !== types.param) return undefined;
  const list = decodeMessage(pilot.classId, types.param, answer.body, answer.flags) as unknown as ParameterList;
  const value = (name: string) => list.parameters.find((parameter) => parameter.name === name)?.valueInt;
  const instance = value('joystickInst');
  if (instance === undefined || instance < 0) return undefined;
  const system = value('joystickSys') ?? robot.system;
  return addressOf({ system, classId: classes.joystick, instance }, widthsOf(console));
}

export interface DrivingOptions {
  over?: boolean; // take the robot from whoever drives it
  ended?: (why: string) => void; // somebody else has taken it, or the connection is lost
}

const stickTime = 3000; // ms; who was driving lets the stick go when its lease is not renewed
const stickPause = 250;

// Takes the driving lease and the stick, ends all other pilots, and lets this one drive. Throws who drives.
export async function beginDriving(
  console: Console,
  robot: Robot,
  { pilot, joystick }: StickPilot,
  { over = false, ended }: DrivingOptions = {},
): Promise<void> {
  await console.leases.take(robot.system, {
    stick: joystick,
    over,
    ended: (why) => {
      console.client.releaseStick();
      ended?.(why);
    },
  });
  try {
    await takeStick(console, joystick, over);
    // A pilot that is on listens to whoever had the stick before, until it notices that he is gone; and it does not
    // begin with a stick that is held.
    await console.fleet.turn(pilot, false);
    await activate(console, robot, pilot);
  } catch (error) {
    console.client.releaseStick();
    await console.leases.release(robot.system);
    throw error;
  }
}

// Lets a pilot drive that needs no stick.
export function startPilot(console: Console, robot: Robot, pilot: Component): Promise<void> {
  return console.leases.during(robot.system, () => activate(console, robot, pilot));
}

async function activate(console: Console, robot: Robot, pilot: Component): Promise<void> {
  const chassis = firstOf(robot, 'Chassis');
  if (chassis === undefined) throw new Error(`robot ${robot.system} has no chassis`);
  // Not by their states as last heard: these may be two seconds old.
  for (const other of pilotsOf(robot)) if (other !== pilot) await console.fleet.turn(other, false);
  await console.fleet.turn(chassis, true);
  await command(console.client, chassis, 'Chassis.SET_ACTIVE_PILOT', { activePilot: pilot.address });
  await console.fleet.turn(pilot, true);
}

async function takeStick(console: Console, joystick: number, over: boolean): Promise<void> {
  for (const deadline = performance.now() + stickTime; ; ) {
    try {
      return await console.client.takeStick(joystick);
    } catch (error) {
      if (!over || performance.now() > deadline) throw error;
      await new Promise((resolve) => setTimeout(resolve, stickPause));
    }
  }
}

export async function endDriving(console: Console, robot: Robot, { pilot }: StickPilot): Promise<void> {
  const chassis = firstOf(robot, 'Chassis');
  try {
    if (chassis !== undefined)
      await stopCommand(console.client, chassis, 'Chassis.SET_ACTIVE_PILOT', { activePilot: noPilot });
    await console.fleet.turn(pilot, false);
  } finally {
    console.client.releaseStick();
    await console.leases.release(robot.system);
  }
}
