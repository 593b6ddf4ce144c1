// A box for the name of a component, completed from those that have registered.

import { useId } from 'preact/hooks';
import { type Console, nameOf, useConsole } from '../app/console';

interface Properties {
  label: string;
  value: string;
  placeholder?: string;
  required?: boolean;
  change: (name: string) => void;
}

export const suggestionsMax = 100; // of thousands a browser shows no more at once

export function ComponentInput({ label, value, placeholder = 'Ladar(1/0)', required = false, change }: Properties) {
  const console = useConsole();
  const list = useId();
  return (
    <label>
      {label}{' '}
      <input
        list={list}
        required={required}
        placeholder={placeholder}
        value={value}
        onInput={(event) => change(event.currentTarget.value)}
      />
      <datalist id={list}>
        {suggestionsFor(value, registered(console)).map((name) => (
          <option key={name} value={name} />
        ))}
      </datalist>
    </label>
  );
}

function* registered(console: Console): Generator<string> {
  for (const { components } of console.fleet.robots.value)
    for (const { address } of components) yield nameOf(console, address);
}

// The first names that contain the text.
export function suggestionsFor(text: string, names: Iterable<string>): string[] {
  const wanted = text.trim().toLowerCase();
  const found: string[] = [];
  for (const name of names) {
    if (found.length === suggestionsMax) break;
    if (name.toLowerCase().includes(wanted)) found.push(name);
  }
  return found;
}
