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

const suggestionsMax = 100; // of a fleet with thousands a browser shows no more

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
        {suggestions(console, value).map((name) => (
          <option key={name} value={name} />
        ))}
      </datalist>
    </label>
  );
}

// Names that contain the text.
function suggestions(console: Console, text: string): string[] {
  const wanted = text.trim().toLowerCase();
  const names: string[] = [];
  for (const { components } of console.fleet.robots.value)
    for (const { address } of components) {
      const name = nameOf(console, address);
      if (name.toLowerCase().includes(wanted) && names.push(name) === suggestionsMax) return names;
    }
  return names;
}
