import assert from 'node:assert/strict';
import { test } from 'node:test';
import { signal } from '@preact/signals';
import { classId } from '../codec/catalogue';
import type { Component, ComponentState, Robot } from '../model/fleet';
import { followedOf, localisationOf } from './follow';

const component = (name: string, instance: number, state: ComponentState) =>
  ({ address: 100 * classId(name)! + instance, classId: classId(name), instance, state: signal(state) }) as Component;

test('another component is followed when it goes on, or another one is there', () => {
  const [first, second] = [component('Scan2d', 0, 'unknown'), component('Scan2d', 1, 'unknown')];
  const robot = { system: 3, components: [first, second] } as Robot;
  const before = followedOf(robot);
  second!.state.value = 'on';
  const after = followedOf(robot);
  assert.notEqual(after, before);
  first!.state.value = 'off';
  assert.equal(followedOf(robot), after, 'it is the same one');
  robot.components[0] = component('Scan2d', 2, 'unknown');
  robot.components[0] = component('Position', 0, 'unknown');
  assert.notEqual(followedOf(robot), after, 'as many, but others');
});

test('of a localisation, what it measures is shown beside what it believes', () => {
  const point = (type: number) => ({ x: type, y: 0, z: 0, type, layer: 0 });
  const found = localisationOf([1, 2, 3, 10, 99].map(point));
  assert.deepEqual(
    [found.samples, found.measurements, found.reflectors, found.lines].map((list) => list.map(({ x }) => x)),
    [[1], [2], [3], [10]],
  );
});
