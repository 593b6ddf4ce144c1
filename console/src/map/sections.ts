// A big picture as sections, in several resolutions: a map loads those that it needs, and a picture may be larger than
// what a browser draws. The first level has all pixels, each further one half of them, until one section holds all.

import { type Place, worldFileOf } from './world_file';

export interface Section {
  name: string;
  x: number; // of the picture, in its pixels
  y: number;
  width: number;
  height: number;
  factor: number; // pixels of the picture to one of the section
  worldFile: string;
}

export const sectionEdge = 1024; // pixels

export function sectionsOf(size: { width: number; height: number }, place: Place, edge = sectionEdge): Section[] {
  const sections: Section[] = [];
  for (let factor = 1; ; factor *= 2) {
    const step = edge * factor;
    for (let y = 0; y < size.height; y += step)
      for (let x = 0; x < size.width; x += step)
        sections.push({
          name: `${factor}-${y / step}-${x / step}`,
          x,
          y,
          width: Math.min(step, size.width - x),
          height: Math.min(step, size.height - y),
          factor,
          worldFile: worldFileOf({
            north: place.north - y * place.cell,
            west: place.west + x * place.cell,
            cell: place.cell * factor,
          }),
        });
    if (step >= size.width && step >= size.height) return sections;
  }
}
