// Pictures of 20 by 20 units, drawn by lines in the colour of the text.

const paths = {
  robots: 'M4 8h12v8H4zM10 8V4M8 4h4M7 12h.01M13 12h.01M2 11v3M18 11v3',
  map: 'M2 5l5-2 6 2 5-2v12l-5 2-6-2-5 2zM7 3v12M13 5v12',
  stick: 'M10 11V5M10 5a2 2 0 1 0-.01 0M4 11h12l1 6H3z',
  text: 'M3 4h14v10H9l-4 3v-3H3zM6 8h8M6 11h5',
  plot: 'M3 3v14h14M5 13l4-5 3 3 5-6',
  tree: 'M10 3v4M4 13v-3h12v3M10 7v6M8 3h4v3H8zM2 13h4v4H2zM8 13h4v4H8zM14 13h4v4h-4z',
  disc: 'M10 2a8 8 0 1 0 .01 0M10 7a3 3 0 1 0 .01 0',
  more: 'M4 10h.01M10 10h.01M16 10h.01',
  full: 'M3 8V3h5M12 3h5v5M17 12v5h-5M8 17H3v-5',
  wide: 'M2 10h16M5 7l-3 3 3 3M15 7l3 3-3 3',
  move: 'M10 2v16M2 10h16M8 4l2-2 2 2M8 16l2 2 2-2M4 8l-2 2 2 2M16 8l2 2-2 2',
  cube: 'M10 2l7 4v8l-7 4-7-4V6zM3 6l7 4 7-4M10 10v8',
  tiles: 'M3 3h6v6H3zM11 3h6v4h-6zM11 9h6v8h-6zM3 11h6v6H3z',
  sun: 'M10 6a4 4 0 1 0 .01 0M10 1v2M10 17v2M1 10h2M17 10h2M4 4l1 1M15 15l1 1M16 4l-1 1M5 15l-1 1',
  moon: 'M15 12A6 6 0 0 1 8 4a7 7 0 1 0 7 8z',
  stop: 'M7 2h6l5 5v6l-5 5H7l-5-5V7z',
  close: 'M5 5l10 10M15 5L5 15',
  undo: 'M7 4L3 8l4 4M3 8h9a4.5 4.5 0 0 1 0 9H8',
  redo: 'M13 4l4 4-4 4M17 8H8a4.5 4.5 0 0 0 0 9h4',
  wrench:
    'M12.5 3a4 4 0 0 1 4.4 5.3L14 7l-1.6 1.6L13.700 12l-1.500 0L5.500 18.500a1.800 1.800 0 0 1-2.500-2.500L9.500 9.400A4 4 0 0 1 12.500 3z',
  plus: 'M10 4v12M4 10h12',
  minus: 'M4 10h12',
  centre: 'M10 2v4M10 14v4M2 10h4M14 10h4M10 7a3 3 0 1 0 .01 0',
  pause: 'M6 4v12M14 4v12',
  play: 'M6 4l10 6-10 6z',
  warning: 'M10 2l8 15H2zM10 8v4M10 14.5v.01',
} as const;

export type IconName = keyof typeof paths;

export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 20 20" aria-hidden="true">
      <path d={paths[name]} />
    </svg>
  );
}
