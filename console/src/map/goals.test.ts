import assert from 'node:assert/strict';
import { test } from 'node:test';
import { GoalLists, Goals, readUtmPlaces } from './goals';

test('a file of the original is read', () => {
  const text = '# course\n32U 550000.25m E 5800000.5m N\n\n32 u 550010 E 5800020 N\r\n';
  assert.deepEqual(readUtmPlaces(text), [
    { zone: 32, band: 18, easting: 550000250, northing: 5800000500 },
    { zone: 32, band: 18, easting: 550010000, northing: 5800020000 },
  ]);
});

test('a line that is no place is named', () => {
  for (const bad of ['0U 1 E 1 N', '61U 1 E 1 N', '32I 1 E 1 N', '32U 1 N 1 E', '32U x E 1 N', '32U 1 E', '1,2'])
    assert.throws(() => readUtmPlaces(`32U 1 E 1 N\n${bad}`), /line 2 is no place/, bad);
  assert.throws(() => readUtmPlaces('# nothing\n'), /no places/);
  const lines = (count: number) => '32U 1 E 1 N\n'.repeat(count);
  assert.equal(readUtmPlaces(lines(1000)).length, 1000);
  assert.throws(() => readUtmPlaces(lines(1001)), /1001 places/);
});

const pose = (x: number, y: number) => ({ x, y, rho: 0 });

test('distance and direction of the present goal, and the way to the last one', () => {
  const goals = new Goals();
  assert.equal(goals.from(pose(0, 0)), undefined);
  goals.set([
    { x: 3000, y: 4000 },
    { x: 3000, y: 14000 },
  ]);
  const found = goals.from(pose(0, 0));
  assert.equal(found?.distance, 5000);
  assert.equal(found?.inAll, 15000);
  assert(Math.abs((found?.direction ?? 0) - Math.atan2(4, 3)) < 1e-9);
});

test('the next goal counts from the turnover on, and the last one stays', () => {
  const goals = new Goals();
  goals.set([
    { x: 10000, y: 0 },
    { x: 20000, y: 0 },
  ]);
  goals.pass(pose(8000, 0));
  assert.equal(goals.index.value, 0, 'at the turnover');
  goals.pass(pose(8001, 0));
  assert.equal(goals.index.value, 1, 'below it');
  goals.pass(pose(20000, 0));
  assert.equal(goals.index.value, 1);
  goals.step(-1);
  goals.step(-1);
  assert.equal(goals.index.value, 0);
});

test('a robot with goals before it is followed until it comes to the last one', () => {
  const followed = new Map<number, (at: { x: number; y: number }) => void>();
  const lists = new GoalLists((system, take) => {
    followed.set(system, take);
    return () => followed.delete(system);
  });
  const goals = lists.of(3);
  assert.equal(lists.of(3), goals);
  goals.set([{ x: 0, y: 0 }]);
  assert.equal(followed.size, 0, 'there is no next one');
  goals.set([
    { x: 0, y: 0 },
    { x: 9000, y: 0 },
  ]);
  followed.get(3)?.({ x: 5000, y: 0 });
  assert.equal(goals.index.value, 0);
  followed.get(3)?.({ x: 1000, y: 0 });
  assert.equal(goals.index.value, 1);
  assert.equal(followed.size, 0);
});
