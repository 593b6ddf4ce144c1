// Scans that show when they were made, so that a page shows how old they are.

const day = 60_000; // ms: after this the clock of the scans begins anew
const nearest = 1000; // mm

// A scan of 361 points whose distance is the time: 1 mm a ms.
export function clockScan() {
  const points = 361;
  const body = Buffer.alloc(24 + 16 * points);
  body.writeInt32LE(100_000, 8);
  body.writeFloatLE(-Math.PI / 2, 12);
  body.writeFloatLE(Math.PI / 2, 16);
  body.writeInt32LE(points, 20);
  return () => {
    const distance = nearest + (Date.now() % day);
    for (let i = 0; i < points; ++i) {
      body.writeFloatLE((Math.PI * i) / (points - 1) - Math.PI / 2, 24 + 16 * i);
      body.writeInt32LE(distance, 28 + 16 * i);
    }
    return Buffer.from(body);
  };
}

// How old the scan is that the page shows now, in ms.
export const ageShown = (tile) =>
  tile.getByText(/points; the nearest/).evaluate(
    (element, [least, clock]) => {
      const metres = Number(/is ([\d.]+) m/.exec(element.textContent)?.[1]);
      return (((Date.now() - (1000 * metres - least)) % clock) + clock) % clock;
    },
    [nearest, day],
  );

export const sorted = (list) => [...list].sort((a, b) => a - b).map(Math.round);

export const median = (list) => sorted(list)[Math.floor(list.length / 2)];
