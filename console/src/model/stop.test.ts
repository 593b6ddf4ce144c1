import assert from 'node:assert/strict';
import { test } from 'node:test';
import { classId } from '../codec/catalogue';
import { types } from '../tims/header';
import type { Component, Robot } from './fleet';
import { stopRobots } from './stop';

const component = (system: number, className: string) =>
  ({ address: system * 0x100 + classId(className)!, classId: classId(className) }) as Component;
const robot = (system: number, ...classes: string[]): Robot => ({
  system,
  components: classes.map((name) => component(system, name)),
});

class Played {
  asked: number[] = [];
  refusing = new Set<number>();
  constructor(private readonly robots: Robot[]) {}
  readonly client = {
    call: (dest: number) => {
      this.asked.push(dest);
      const body = new TextEncoder().encode('it is broken');
      return Promise.resolve({ type: this.refusing.has(dest) ? types.error : types.ok, flags: 0, body });
    },
  };
  stop(...systems: number[]) {
    return stopRobots(this.client, { robot: (system) => this.robots.find((each) => each.system === system) }, systems);
  }
}

const chassis = (system: number) => component(system, 'Chassis').address;
const pilot = (system: number) => component(system, 'Pilot').address;

test('all chassis and pilots of the robots are told, nobody else', async () => {
  const played = new Played([robot(1, 'Chassis', 'Ladar', 'Pilot'), robot(2, 'Chassis'), robot(3, 'Chassis')]);
  await played.stop(1, 2);
  assert.deepEqual(played.asked, [chassis(1), pilot(1), chassis(2)]);
});

test('who stops a robot that is not listed is told so, and the others stop', async () => {
  const played = new Played([robot(1, 'Chassis'), robot(4, 'Ladar')]);
  await assert.rejects(played.stop(7, 1, 4), /robot 7, 4 is listed: it was not stopped/);
  assert.deepEqual(played.asked, [chassis(1)]);
  await assert.rejects(new Played([]).stop(), /No robot is listed/);
});

test('what refuses is named when all have been told', async () => {
  const played = new Played([robot(1, 'Chassis', 'Pilot')]);
  played.refusing.add(chassis(1));
  await assert.rejects(played.stop(1, 9), /robot 9 is listed.*; it is broken/);
  assert.deepEqual(played.asked, [chassis(1), pilot(1)]);
});
