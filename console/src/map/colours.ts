// The colours of maps, taken from the style sheet, so that light and dark are one place.

export interface MapColours {
  ground: string;
  grid: string;
  axis: string;
  text: string;
  wall: string;
  scan: string;
  reflector: string;
  moving: string;
  transparent: string;
  rain: string;
  dirt: string;
  path: string;
  pilot: string;
  goal: string;
  particle: string;
  object: string;
  gps: string;
  stale: string;
  robots: string[];
}

const known = new Map<string | undefined, MapColours>(); // by theme

// Asked of the style sheet once: that takes longer than to draw a scan.
export function mapColours(): MapColours {
  const { theme } = document.documentElement.dataset;
  const colours = known.get(theme) ?? readColours();
  known.set(theme, colours);
  return colours;
}

function readColours(): MapColours {
  const style = getComputedStyle(document.documentElement);
  const colour = (name: string) => style.getPropertyValue(`--map-${name}`).trim();
  return {
    ground: colour('ground'),
    grid: colour('grid'),
    axis: colour('axis'),
    text: colour('text'),
    wall: colour('wall'),
    scan: colour('scan'),
    reflector: colour('reflector'),
    moving: colour('moving'),
    transparent: colour('transparent'),
    rain: colour('rain'),
    dirt: colour('dirt'),
    path: colour('path'),
    pilot: colour('pilot'),
    goal: colour('goal'),
    particle: colour('particle'),
    object: colour('object'),
    gps: colour('gps'),
    stale: colour('stale'),
    robots: [1, 2, 3, 4, 5, 6].map((number) => colour(`robot-${number}`)),
  };
}
