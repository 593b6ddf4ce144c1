import assert from 'node:assert/strict';
import { test } from 'node:test';
import { matrixOf, orientations, pixelAt, turnedSize } from './orientation';

const picture = { width: 4, height: 3 };

// Where the centre of a pixel of the picture is shown.
function shown(name: string, column: number, row: number): [number, number] {
  const orientation = orientations[name];
  assert(orientation !== undefined);
  const [a, b, c, d, e, f] = matrixOf(orientation, picture);
  const [u, v] = [column + 0.5, row + 0.5];
  return [Math.floor(a * u + c * v + e), Math.floor(b * u + d * v + f)];
}

test('a quarter turn to the right brings the upper left corner to the upper right', () => {
  assert.deepEqual(shown('90° to the right', 0, 0), [2, 0]);
  assert.deepEqual(shown('90° to the left', 0, 0), [0, 3]);
  assert.deepEqual(shown('180°', 0, 0), [3, 2]);
  assert.deepEqual(shown('mirrored', 0, 0), [3, 0]);
});

test('what is shown at a place is found again in the picture', () => {
  for (const [name, orientation] of Object.entries(orientations))
    for (let column = 0; column < picture.width; ++column)
      for (let row = 0; row < picture.height; ++row) {
        const [x, y] = shown(name, column, row);
        const { width, height } = turnedSize(picture, orientation);
        assert(x >= 0 && x < width && y >= 0 && y < height, name);
        assert.deepEqual(pixelAt(orientation, picture, x, y), [column, row], name);
      }
});
