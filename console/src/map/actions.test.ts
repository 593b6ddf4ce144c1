import assert from 'node:assert/strict';
import { test } from 'node:test';
import { goalSpeedFor } from './actions';

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
