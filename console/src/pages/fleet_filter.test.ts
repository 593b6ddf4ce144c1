import assert from 'node:assert/strict';
import { test } from 'node:test';
import { matchesRobot } from './fleet_filter';

test('robots are found by number, by the name of their router and by their state', () => {
  const robot = { system: 12, name: 'Scout-left', words: ['bad link', 'away'] };
  for (const filter of ['', ' ', '12', '2', 'scout', 'robot 12', 'AWAY', 'link left'])
    assert(matchesRobot(robot, filter), filter);
  for (const filter of ['3', 'works', 'scout 3']) assert(!matchesRobot(robot, filter), filter);
  assert(matchesRobot({ system: 0, name: null, words: ['off'] }, 'base'));
});
