// The map in which a robot plans its paths, asked of its Path, as a picture.

import type { Console } from '../app/console';
import { decodeMessage } from '../codec/catalogue';
import type { GridMapData } from '../codec/messages';
import { command } from '../model/commands';
import type { Component } from '../model/fleet';
import type { Plan } from './scene';

const gridMap = -21; // DBG_GRIDMAP of class Path
const occupiedFrom = 128;
const wall = [128, 139, 155, 255]; // readable on light and on dark ground

export async function planOf(console: Console, path: Component): Promise<Plan | undefined> {
  const answer = await command(console.client, path, 'Path.GET_DBG_GRIDMAP');
  if (answer.type !== gridMap) return undefined;
  return pictureOf(decodeMessage(path.classId, gridMap, answer.body, answer.flags) as unknown as GridMapData);
}

// Cells run along x (north) first; free ones are left open.
function pictureOf({ gridNumX: rows, gridNumY: columns, offsetX, offsetY, scale, occupancy }: GridMapData): Plan {
  const image = new ImageData(columns, rows);
  for (let column = 0; column < columns; ++column)
    for (let row = 0; row < rows; ++row)
      if ((occupancy[row + column * rows] ?? 0) >= occupiedFrom)
        image.data.set(wall, 4 * ((rows - 1 - row) * columns + column));
  const picture = new OffscreenCanvas(columns, rows);
  picture.getContext('2d')?.putImageData(image, 0, 0);
  return { picture, north: offsetX - scale / 2 + rows * scale, west: offsetY - scale / 2, cell: scale };
}
