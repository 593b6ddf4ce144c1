// The tiles of the robot's page that is shown, in its address ("#/robot/1?tiles=Chassis/0"). They are kept for who comes again
// without tiles.

import { route, setOption } from '../app/route';
import { moved, type OpenTile, parseTiles, tilesText } from './tiles';

const memory = (system: string | undefined) => `rack.tiles.${system}`;

let opened: string | undefined; // last by hand: it is brought into sight

export const openTiles = () => parseTiles(route.value.options.get('tiles') ?? '');

export function setTiles(tiles: OpenTile[]): void {
  const text = tilesText(tiles);
  setOption('tiles', text);
  localStorage.setItem(memory(route.value.arguments[0]), text);
}

export function recallTiles(system: number): void {
  setOption('tiles', localStorage.getItem(memory(`${system}`)) ?? undefined);
}

export function toggleTile(name: string): void {
  const tiles = openTiles();
  const others = tiles.filter((tile) => tile.name !== name);
  opened = others.length === tiles.length ? name : undefined;
  setTiles(opened === undefined ? others : [...tiles, { name, wide: false }]);
}

// True once.
export function wasOpenedNow(name: string): boolean {
  const is = opened === name;
  if (is) opened = undefined;
  return is;
}

export const isWide = (name: string) => openTiles().some((tile) => tile.name === name && tile.wide);

export function toggleWide(name: string): void {
  setTiles(openTiles().map((tile) => (tile.name === name ? { name, wide: !tile.wide } : tile)));
}

export function moveTile(name: string, by: number): void {
  setTiles(moved(openTiles(), name, by));
}

// To where the other one is.
export function moveTileTo(name: string, other: string): void {
  const names = openTiles().map((tile) => tile.name);
  moveTile(name, names.indexOf(other) - names.indexOf(name));
}
