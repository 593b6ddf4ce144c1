import assert from 'node:assert/strict';
import { test } from 'node:test';
import { types } from './header';
import { neededForQuestion, neededForType } from './rights';

test('reading needs look, parameters configure, all else drive', () => {
  assert.equal(neededForType(types.getContData), 'look');
  assert.equal(neededForType(types.setParam), 'configure');
  assert.equal(neededForType(types.on), 'drive');
  assert.equal(neededForType(types.data), 'drive');
  assert.equal(neededForType(22, 'GDOS'), 'look');
  assert.equal(neededForType(22, 'Camera'), 'drive');
  assert.equal(neededForType(22), 'drive');
});

test('questions read, but for leases, links, faults, routes, and those that change files', () => {
  for (const ask of ['status', 'routes', 'events', 'leases', 'conf_check', 'conf_fleet'])
    assert.equal(neededForQuestion(ask), 'look', ask);
  assert.equal(neededForQuestion('lease'), 'drive');
  for (const ask of ['link', 'fault', 'route_add', 'conf_apply', 'conf_lock', 'conf_'])
    assert.equal(neededForQuestion(ask), 'configure', ask);
});
