// The stick of the drive page: from keys, a pad or a gamepad to the position of a joystick. Pure.

import type { StickPosition } from '../tims/joystick';
import { stickAtRest } from '../tims/joystick';

// Keys that are held: forward and back, turning to the sides, and sideways.
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
const sideways = 'Shift'; // held with what turns

// The name of a key that moves the stick, changes how it moves, or presses one of its buttons; undefined: it does none
// of these.
export function stickKey({ key, code }: { key: string; code: string }): string | undefined {
  const name = digits[code] ?? (key.length === 1 ? key.toLowerCase() : key);
  return axes[name] !== undefined || name === sideways || buttonKeys.includes(name) ? name : undefined;
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
  const axis = keys.has(sideways) ? { x: sum.x, y: 0, z: sum.z + sum.y } : sum;
  return limited({ ...axis, buttons: bitsOf(buttonKeys.map((key) => keys.has(key))) }, speed);
}

// The place of a finger on the pad: -1 to 1, up is forward.
export function stickOfPad(right: number, up: number, speed: number): StickPosition {
  const length = Math.hypot(right, up);
  if (length < deadZone) return stickAtRest;
  const scale = length > 1 ? 1 / length : 1;
  return limited({ x: up * scale, y: right * scale, z: 0, buttons: 0 }, speed);
}

// A gamepad drives by its left stick, sideways by its right one; its first buttons are those of the stick.
export function stickOfGamepad({ axes: values, buttons }: GamepadHeld, speed: number): StickPosition {
  const axis = (i: number) => {
    const value = values[i] ?? 0;
    return Math.abs(value) < deadZone ? 0 : value;
  };
  const pressed = buttonKeys.map((_, i) => buttons[i]?.pressed ?? false);
  return limited({ x: -axis(1), y: axis(0), z: axis(2), buttons: bitsOf(pressed) }, speed);
}

interface GamepadHeld {
  axes: readonly number[];
  buttons: readonly { pressed: boolean }[];
}

const deadZone = 0.12;

const bitsOf = (pressed: boolean[]) => pressed.reduce((bits, is, i) => (is ? bits | (1 << i) : bits), 0);

// "forward 30 %, right −10 %, sideways 0 %, button 1, 3"
export function stickText({ x, y, z, buttons }: StickPosition): string {
  const percent = (value: number) => `${value < 0 ? '−' : ''}${Math.abs(value)} %`;
  const pressed = buttonKeys.map((_, i) => i + 1).filter((number) => (buttons & (1 << (number - 1))) !== 0);
  const text = `forward ${percent(x)}, right ${percent(y)}, sideways ${percent(z)}`;
  return pressed.length === 0 ? text : `${text}, button ${pressed.join(', ')}`;
}

function limited({ x, y, z, buttons }: StickPosition, speed: number): StickPosition {
  const part = (value: number) => Math.round(Math.min(1, Math.max(-1, value)) * speed) + 0;
  return { x: part(x), y: part(y), z: part(z), buttons };
}
