// Numbers for people, with their units; and as people type them.

export function duration(seconds: number | null | undefined): string {
  if (seconds == null) return '';
  const size = Math.abs(seconds);
  if (size < 1e-3) return `${(seconds * 1e6).toFixed(0)} µs`;
  if (size < 1) return `${(seconds * 1e3).toFixed(size < 0.01 ? 1 : 0)} ms`;
  return age(seconds);
}

export function age(seconds: number | null | undefined): string {
  if (seconds == null) return '';
  if (seconds < 60) return `${seconds.toFixed(seconds < 10 ? 1 : 0)} s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min ${Math.floor(seconds % 60)} s`;
  if (seconds < 86400) return `${Math.floor(seconds / 3600)} h ${Math.floor((seconds % 3600) / 60)} min`;
  return `${Math.floor(seconds / 86400)} d ${Math.floor((seconds % 86400) / 3600)} h`;
}

export function bytes(count: number | null | undefined): string {
  if (count == null) return '';
  const units = ['B', 'kB', 'MB', 'GB', 'TB'];
  let value = count;
  let unit = 0;
  while (value >= 1000 && unit + 1 < units.length) {
    value /= 1000;
    ++unit;
  }
  return `${value.toFixed(unit === 0 || value >= 100 ? 0 : 1)} ${units[unit]}`;
}

export function percent(share: number | null | undefined): string {
  return share == null ? '' : `${(100 * share).toFixed(share < 0.1 ? 1 : 0)} %`;
}

export function metres(millimetres: number): string {
  return `${fixed(millimetres / 1000, 2)} m`;
}

// A time of the wire as UTC: "2026-11-27 14:03:01". Devices also send what is no time.
export function utcText(seconds: bigint | number): string {
  const time = new Date(Number(seconds) * 1000);
  return Number.isNaN(time.getTime()) ? 'no time' : time.toISOString().replace('T', ' ').slice(0, 19);
}

export const radians = (angle: number) => (angle * Math.PI) / 180;

// RACK's angles grow clockwise; people read degrees.
export function degrees(radians: number): string {
  return `${fixed((radians * 180) / Math.PI, 1)}°`;
}

// Of a direction: from 0.0 to 359.9.
export function heading(radians: number): string {
  const turn = 2 * Math.PI;
  const text = degrees(((radians % turn) + turn) % turn);
  return text === '360.0°' ? '0.0°' : text;
}

// Without the sign of what is rounded to zero.
export function fixed(value: number, digits: number): string {
  return (Math.round(value * 10 ** digits) / 10 ** digits + 0).toFixed(digits);
}

// With a point or a comma. Undefined: it is no finite number.
export function numberIn(text: string): number | undefined {
  const number = Number(text.replace(',', '.'));
  return text.trim() !== '' && Number.isFinite(number) ? number : undefined;
}
