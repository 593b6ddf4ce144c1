import assert from 'node:assert/strict';
import { test } from 'node:test';
import { kitsOf, moved, parseTiles, placesOf, tilesText } from './tiles';

const text = 'Chassis/0,Camera/0!,Scan2d/0';
const tiles = parseTiles(text);

test('tiles are a part of an address', () => {
  assert.deepEqual(
    tiles.map(({ name, wide }) => [name, wide]),
    [
      ['Chassis/0', false],
      ['Camera/0', true],
      ['Scan2d/0', false],
    ],
  );
  assert.equal(tilesText(tiles), text);
  assert.deepEqual(parseTiles(''), []);
});

test('each takes the next columns; one that is too wide begins at the first', () => {
  assert.deepEqual(placesOf(tiles, 1), ['1 / span 1', '1 / span 1', '1 / span 1']);
  assert.deepEqual(placesOf(tiles, 2), ['1 / span 1', '1 / span 2', '1 / span 1']);
  assert.deepEqual(placesOf(tiles, 3), ['1 / span 1', '2 / span 2', '1 / span 1']);
  assert.deepEqual(placesOf(tiles, 4), ['1 / span 1', '2 / span 2', '4 / span 1']);
});

test('a tile is moved, at most to an end', () => {
  const order = (name: string, by: number) => tilesText(moved(tiles, name, by));
  assert.equal(order('Chassis/0', 1), 'Camera/0!,Chassis/0,Scan2d/0');
  assert.equal(order('Scan2d/0', -2), 'Scan2d/0,Chassis/0,Camera/0!');
  assert.equal(order('Scan2d/0', 1), text);
  assert.equal(order('Chassis/0', -1), text);
  assert.equal(order('Gps/0', 1), text);
});

test('what belongs together is offered as far as the robot has it', () => {
  const kits = kitsOf(['Chassis/0', 'Pilot/1', 'Pilot/2', 'Position/0']);
  assert.deepEqual(
    kits.map((kit) => [kit.name, tilesText(kit.tiles)]),
    [
      ['Driving', 'Chassis/0,Pilot/1'],
      ['Path', 'Pilot/1,Position/0'],
    ],
  );
  assert.deepEqual(kitsOf([]), []);
});
