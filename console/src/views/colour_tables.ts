// Colours for pictures of one number a pixel: a grey level, a range, a temperature. A table is a list of stops; the
// colours between two of them are mixed. The tables are those of the original's camera window. Pure.

export type Pixel = [red: number, green: number, blue: number];
type Stop = [value: number, colour: Pixel];

const black: Pixel = [0, 0, 0];
const white: Pixel = [255, 255, 255];
const red: Pixel = [255, 0, 0];
const green: Pixel = [0, 255, 0];
const blue: Pixel = [0, 0, 255];
const cyan: Pixel = [0, 255, 255];
const yellow: Pixel = [255, 255, 0];
const orange: Pixel = [255, 200, 0];

const valueMax = 0xffff;
const noValue: Stop = [valueMax, red]; // what cameras of ranges send where nothing was measured

const grey = (most: number): Stop[] => [[0, black], [most, white], noValue];

const stops: Record<string, Stop[]> = {
  'grey to 63': grey(63),
  'grey to 127': grey(127),
  'grey to 255': grey(255),
  'grey to 1023': grey(1023),
  'grey to 4095': grey(4095),
  'grey from 4095': [[0, white], [4095, black], noValue],
  'range indoors': [
    [0, black],
    [1000, blue],
    [2000, green],
    [4000, cyan],
    [6000, yellow],
    [valueMax - 1, white],
    noValue,
  ],
  'range outdoors': [
    [0, black],
    [3000, blue],
    [6000, green],
    [9000, cyan],
    [15000, yellow],
    [valueMax - 1, white],
    noValue,
  ],
  'thermal, spectrum': [
    [0, black],
    [48, blue],
    [96, cyan],
    [154, green],
    [202, yellow],
    [250, red],
    [valueMax, white],
  ],
  'thermal, red': [
    [0, black],
    [48, blue],
    [154, red],
    [252, orange],
    [valueMax, white],
  ],
};

export const tableNames = Object.keys(stops);

export type ColourTable = (value: number) => Pixel;

// Undefined: there is none of this name; grey levels are shown as they are.
export function colourTable(name: string): ColourTable | undefined {
  const list = stops[name];
  return list === undefined ? undefined : (value) => mixed(list, Math.max(0, Math.min(valueMax, value)));
}

function mixed(list: Stop[], value: number): Pixel {
  const next = list.findIndex(([at]) => at >= value);
  const [above, to] = list[next] ?? noValue;
  const [below, from] = list[Math.max(0, next - 1)] ?? noValue;
  const part = above === below ? 0 : (value - below) / (above - below);
  const mix = (i: 0 | 1 | 2) => Math.round(from[i] + part * (to[i] - from[i]));
  return [mix(0), mix(1), mix(2)];
}
