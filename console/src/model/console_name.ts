// How others see this console: a name that its user may change, kept in this browser.

import { effect, type Signal, signal } from '@preact/signals';

const nameKey = 'tims.name';
const nameBytesMax = 31;

export function storedName(): Signal<string> {
  const name = signal(fittingName(localStorage.getItem(nameKey) ?? '') || newName());
  effect(() => localStorage.setItem(nameKey, name.value));
  return name;
}

// "tablet 27"
function newName(): string {
  const touch = matchMedia('(pointer: coarse)').matches;
  const device = !touch ? 'desk' : Math.min(screen.width, screen.height) < 600 ? 'phone' : 'tablet';
  return `${device} ${1 + Math.floor(99 * Math.random())}`;
}

// As much of it as the router takes.
export function fittingName(name: string): string {
  let fitting = '';
  for (const character of name) {
    if (new TextEncoder().encode(fitting + character).length > nameBytesMax) break;
    fitting += character;
  }
  return fitting;
}
