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

// What one wants to see at once, as far as a robot has it: the first component of each class.
const kits: [name: string, classes: string[]][] = [
  ['Driving', ['Chassis', 'Scan2d', 'Camera', 'Pilot']],
  ['Localisation', ['Position', 'Mcl', 'Gps', 'Compass']],
  ['Path', ['Path', 'Pilot', 'Position', 'Planner']],
  ['Sensors', ['Ladar', 'Scan2d', 'Scan3d', 'Camera', 'Gyro', 'ObjRecog']],
];

// `names`: of the components, such as "Chassis/0".
export function kitsOf(names: string[]): { name: string; tiles: OpenTile[] }[] {
  return kits
    .map(([name, classes]) => {
      const found = classes.flatMap((each) => names.find((other) => other.startsWith(`${each}/`)) ?? []);
      return { name, tiles: found.map((tile) => ({ name: tile, wide: false })) };
    })
    .filter(({ tiles }) => tiles.length > 1);
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
