// Where a background picture lies: its world file (.tfw, .jgw, .pgw) gives six numbers, one a line: metres a pixel to
// the east, two rotations, metres a pixel to the north (negative), and the centre of the upper left pixel, east and
// north. Pure.

export interface Place {
  north: number; // upper edge, mm
  west: number; // left edge
  cell: number; // mm a pixel
}

// The file of a picture that lies there, in the coordinates of the map.
export function worldFileOf({ north, west, cell }: Place): string {
  const width = cell / 1000;
  return `${[width, 0, 0, -width, west / 1000 + width / 2, north / 1000 - width / 2].join('\n')}\n`;
}

// `origin`: what the map's origin has in the coordinates of the file, in m. Throws what is wrong with it.
export function readWorldFile(text: string, origin: { north: number; east: number }): Place {
  const numbers = text
    .trim()
    .split(/\s+/)
    .map((part) => Number(part.replace(',', '.')));
  if (numbers.length !== 6 || !numbers.every(Number.isFinite)) throw new Error('a world file has six numbers');
  const [width = 0, turnX = 0, turnY = 0, height = 0, east = 0, north = 0] = numbers;
  if (turnX !== 0 || turnY !== 0) throw new Error('this picture is turned: only those with north up can be shown');
  if (!(width > 0) || Math.abs(width + height) > 1e-3 * width) throw new Error('its pixels are not square');
  return {
    north: 1000 * (north + width / 2 - origin.north),
    west: 1000 * (east - width / 2 - origin.east),
    cell: 1000 * width,
  };
}
