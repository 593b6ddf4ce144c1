// Which tiles a robot's page shows, in which order, and which are two columns wide: "Chassis/0,Camera/0!". Pure.

export interface OpenTile {
  name: string;
  wide: boolean;
}

export function parseTiles(text: string): OpenTile[] {
  return text
    .split(',')
    .filter((tile) => tile !== '')
    .map((tile) => ({ name: tile.replace(/!$/, ''), wide: tile.endsWith('!') }));
}

export function tilesText(tiles: OpenTile[]): string {
  return tiles.map(({ name, wide }) => (wide ? `${name}!` : name)).join(',');
}

// The columns of each tile, as values of grid-column: the next free ones. One that is too wide for the rest of them begins
// at the first.
export function placesOf(tiles: OpenTile[], columns: number): string[] {
  let next = 0;
  return tiles.map(({ wide }) => {
    const width = wide ? Math.min(2, columns) : 1;
    const begin = next + width > columns ? 0 : next;
    next = (begin + width) % columns;
    return `${begin + 1} / span ${width}`;
  });
}

// `by` places further. Beyond an end: to it.
export function moved(tiles: OpenTile[], name: string, by: number): OpenTile[] {
  const from = tiles.findIndex((tile) => tile.name === name);
  const tile = tiles[from];
  if (tile === undefined) return tiles;
  const others = tiles.filter((each) => each !== tile);
  const to = Math.min(others.length, Math.max(0, from + by));
  return [...others.slice(0, to), tile, ...others.slice(to)];
}
