// The stick of the drive page: from keys, a pad or a gamepad to the position of a joystick. Pure.

import type { StickPosition } from '../tims/joystick';
import { stickAtRest } from '../tims/joystick';

// Keys that are held: forward and back, to the sides, and with Shift sideways.
const axes: Record<string, Partial<StickPosition>> = {
  ArrowUp: { x: 1 },
  ArrowDown: { x: -1 },
  ArrowLeft: { y: -1 },
  ArrowRight: { y: 1 },
  w: { x: 1 },
  s: { x: -1 },
  a: { y: -1 },
  d: { y: 1 },
  q: { z: -1 },
  e: { z: 1 },
};

// The block of digits drives like the arrows, as in the original.
const digits: Record<string, string> = {
  Numpad8: 'ArrowUp',
  Numpad2: 'ArrowDown',
  Numpad4: 'ArrowLeft',
  Numpad6: 'ArrowRight',
};
const buttonKeys = ['F1', 'F2', 'F3', 'F4'];

// The name of a key that moves the stick or presses one of its buttons; undefined: it does neither.
export function stickKey({ key, code }: { key: string; code: string }): string | undefined {
  const name = digits[code] ?? (key.length === 1 ? key.toLowerCase() : key);
  return axes[name] !== undefined || buttonKeys.includes(name) ? name : undefined;
}

// A key that is none of the stick's stops the robot and takes its pilot away, as in the original: who presses keys in
// haste wants it to stand. Keys by which one moves about in the page, and Shift and the like, do nothing.
export function isAnyOtherKey({ key, code }: { key: string; code: string }): boolean {
  if (stickKey({ key, code }) !== undefined || key === ' ' || code === 'Numpad5') return false; // 5: straight on
  return key.length === 1 || otherKeys.includes(key);
}

const otherKeys = ['Escape', 'Backspace', 'Delete', 'Insert', 'End', 'Clear'];

// `speed`: percent of the stick's range.
export function stickOfKeys(keys: ReadonlySet<string>, speed: number): StickPosition {
  const sum = { x: 0, y: 0, z: 0 };
  for (const key of keys) {
    const axis = axes[key];
    sum.x += axis?.x ?? 0;
    sum.y += axis?.y ?? 0;
    sum.z += axis?.z ?? 0;
  }
  const buttons = buttonKeys.reduce((bits, key, i) => (keys.has(key) ? bits | (1 << i) : bits), 0);
  return limited({ ...sum, buttons }, speed);
}

// The place of a finger on the pad: -1 to 1, up is forward.
export function stickOfPad(right: number, up: number, speed: number): StickPosition {
  const length = Math.hypot(right, up);
  if (length < deadZone) return stickAtRest;
  const scale = length > 1 ? 1 / length : 1;
  return limited({ x: up * scale, y: right * scale, z: 0, buttons: 0 }, speed);
}

// A gamepad drives by its left stick, sideways by its right one.
export function stickOfGamepad(values: readonly number[], speed: number): StickPosition {
  const axis = (i: number) => {
    const value = values[i] ?? 0;
    return Math.abs(value) < deadZone ? 0 : value;
  };
  return limited({ x: -axis(1), y: axis(0), z: axis(2), buttons: 0 }, speed);
}

const deadZone = 0.12;

function limited({ x, y, z, buttons }: StickPosition, speed: number): StickPosition {
  const part = (value: number) => Math.round(Math.min(1, Math.max(-1, value)) * speed) + 0;
  return { x: part(x), y: part(y), z: part(z), buttons };
}
