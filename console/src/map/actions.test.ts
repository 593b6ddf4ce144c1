import assert from 'node:assert/strict';
import { test } from 'node:test';
import { goalSpeedFor, withMotion } from './actions';

const robot = { x: 0, y: 0, rho: 0 };
const behind = { x: -1000, y: 0 };

test('a robot backs to a goal behind it in which it looks the same way', () => {
  assert(goalSpeedFor(robot, { ...behind, rho: 0.3 }) < 0);
  assert(goalSpeedFor(robot, { ...behind, rho: 6 }) < 0, 'headings go round');
  assert(goalSpeedFor(robot, { ...behind, rho: Math.PI }) > 0, 'it looks back there');
  assert(goalSpeedFor(robot, { x: 1000, y: 0, rho: 0 }) > 0, 'ahead');
  assert(goalSpeedFor(robot, { x: -1000, y: 2000, rho: 0 }) > 0, 'beside');
  assert(goalSpeedFor(undefined, { ...behind, rho: 0 }) > 0, 'nobody knows where it is');
});

test('what is taken back of a position is the belief, not what was driven since', () => {
  const near = (a: { x: number; y: number; rho: number }, b: number[]) =>
    assert.deepEqual(
      [a.x, a.y, a.rho].map((value) => Math.round(1000 * value) / 1000 + 0),
      b,
    );
  const from = { x: 5000, y: 0, rho: 0 };
  near(withMotion(robot, from, from), [0, 0, 0]);
  near(withMotion(robot, from, { x: 6000, y: 200, rho: 0.5 }), [1000, 200, 0.5]);
  const east = { x: 0, y: 0, rho: Math.PI / 2 };
  near(withMotion(east, from, { x: 6000, y: 0, rho: 0 }), [0, 1000, 1.571]);
});
