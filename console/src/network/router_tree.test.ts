import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { RouterItem } from './reports';
import { type TreeRow, treeOfRouters } from './router_tree';

const item = (raw: number, kind: RouterItem['kind'], state: RouterItem['state'] = 'up'): RouterItem => ({
  name: `r${raw}`,
  role: 'system',
  system: raw,
  id: 1,
  address: { name: `Tims(${raw}/1)`, raw: `${raw}` },
  kind,
  state,
  via: null,
  since_s: 1,
  clock: { offset_s: 0.5, uncertainty_s: 0 },
});

// What each router answers; a router without an entry does not answer.
type Fleet = Record<number, RouterItem[]>;
const asker = (fleet: Fleet) => (address: number) =>
  address in fleet ? Promise.resolve(fleet[address] as RouterItem[]) : Promise.reject(new Error('silent'));

const names = (rows: TreeRow[]) =>
  rows.map(({ router, depth, state }) => `${' '.repeat(depth)}${router.name} ${state}`);

const fleet: Fleet = {
  0: [item(9, 'self'), item(1, 'sub'), item(2, 'sub'), item(3, 'sub', 'down')],
  1: [item(1, 'self'), item(9, 'super'), item(11, 'sub')],
  11: [item(11, 'self'), item(1, 'super')],
};

test('each router is below the one that names it; who does not answer is down', async () => {
  const rows = await treeOfRouters(asker(fleet), () => {});
  assert.deepEqual(names(rows), ['r9 up', ' r1 up', '  r11 up', ' r2 down', ' r3 down']);
  assert.deepEqual(
    rows.map(({ clock }) => clock),
    [0, 0.5, 1, 0.5, 0.5],
  );
});

test('one that does not answer hides no other', async () => {
  let giveUp = () => {};
  const silent = new Promise<RouterItem[]>((_, reject) => {
    giveUp = () => reject(new Error('silent'));
  });
  const shown: string[][] = [];
  const whole = treeOfRouters(
    (address) => (address === 2 ? silent : asker(fleet)(address)),
    (rows) => {
      shown.push(names(rows()));
      if (shown.at(-1)?.includes('  r11 up')) giveUp();
    },
  );
  assert.equal(names(await whole)[3], ' r2 down');
  assert.deepEqual(shown[0], ['r9 up', ' r1 asked', ' r2 asked', ' r3 down']);
  assert.ok(shown.some((rows) => rows.includes('  r11 up') && rows.includes(' r2 asked')));
});

test('a fleet in a circle ends, and one that is too large is cut', async () => {
  const circle: Fleet = {
    0: [item(1, 'self'), item(2, 'peer')],
    2: [item(2, 'self'), item(3, 'peer'), item(1, 'peer')],
    3: [item(3, 'self'), item(1, 'peer'), item(2, 'peer')],
  };
  assert.deepEqual(names(await treeOfRouters(asker(circle), () => {})), ['r1 up', ' r2 up', '  r3 up']);
  const rows = await treeOfRouters(asker(circle), () => {}, { routers: 2, asked: 1 });
  assert.deepEqual(names(rows), ['r1 up', ' r2 up']);
});
