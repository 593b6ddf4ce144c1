import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  distanceToLine,
  gridStep,
  headingTo,
  panned,
  placed,
  toScreen,
  toWorld,
  type View,
  viewOf,
  zoomed,
} from './transform';

const size = { width: 800, height: 600 };
const close = (actual: { x: number; y: number }, expected: { x: number; y: number }) => {
  assert(Math.hypot(actual.x - expected.x, actual.y - expected.y) < 1e-6, `${JSON.stringify(actual)}`);
};

test('north is up and east is right', () => {
  const view: View = { centre: { x: 1000, y: 2000 }, scale: 0.1, up: 0 };
  close(toScreen(view, size, { x: 1000, y: 2000 }), { x: 400, y: 300 });
  close(toScreen(view, size, { x: 2000, y: 2000 }), { x: 400, y: 200 });
  close(toScreen(view, size, { x: 1000, y: 3000 }), { x: 500, y: 300 });
});

test('the heading that is up points up', () => {
  const view: View = { centre: { x: 0, y: 0 }, scale: 0.1, up: Math.PI / 2 };
  close(toScreen(view, size, { x: 0, y: 1000 }), { x: 400, y: 200 });
});

test('screen and world are inverse to each other', () => {
  for (const up of [0, 0.3, -2, 3.1]) {
    const view: View = { centre: { x: 12, y: -700 }, scale: 0.037, up };
    close(toScreen(view, size, toWorld(view, size, { x: 17, y: 599 })), { x: 17, y: 599 });
  }
});

test('zooming leaves the point below the pointer', () => {
  const view: View = { centre: { x: 5, y: 6 }, scale: 0.05, up: 0.4 };
  const at = { x: 33, y: 500 };
  close(toWorld(zoomed(view, size, at, 3), size, at), toWorld(view, size, at));
  assert.equal(zoomed(view, size, at, 1e9).scale, 2);
  assert.equal(zoomed(view, size, at, 0).scale, 1e-5);
});

test('panning moves what is seen with the pointer', () => {
  const view: View = { centre: { x: 5, y: 6 }, scale: 0.05, up: 1 };
  const point = toWorld(view, size, { x: 100, y: 100 });
  close(toScreen(panned(view, 30, -20), size, point), { x: 130, y: 80 });
});

test('a view of all points', () => {
  assert.equal(viewOf([], size), undefined);
  const view = viewOf(
    [
      { x: 0, y: 0 },
      { x: 10000, y: 100000 },
    ],
    size,
  )!;
  for (const point of [
    { x: 0, y: 0 },
    { x: 10000, y: 100000 },
  ]) {
    const { x, y } = toScreen(view, size, point);
    assert(x > 0 && x < 800 && y > 0 && y < 600);
  }
});

test('grid steps are 1, 2 or 5', () => {
  assert.equal(gridStep(0.1, 60), 1000);
  assert.equal(gridStep(0.06, 60), 1000);
  assert.equal(gridStep(0.05, 60), 2000);
  assert.equal(gridStep(0.02, 60), 5000);
});

test('robot frame and headings are clockwise from north', () => {
  close(placed({ x: 0, y: 0, rho: Math.PI / 2 }, { x: 100, y: 0 }), { x: 0, y: 100 });
  assert.equal(headingTo({ x: 0, y: 0 }, { x: 0, y: 5 }), Math.PI / 2);
});

test('the distance to a line ends at its ends', () => {
  const [from, to] = [
    { x: 0, y: 0 },
    { x: 10, y: 0 },
  ];
  assert.equal(distanceToLine({ x: 5, y: 3 }, from, to), 3);
  assert.equal(distanceToLine({ x: 13, y: 4 }, from, to), 5);
  assert.equal(distanceToLine({ x: 3, y: 4 }, from, from), 5);
});
