// A box for the name of a component, completed from those that have registered.

import { useId } from 'preact/hooks';
import { nameOf, useConsole } from '../app/console';

interface Properties {
  label: string;
  value: string;
  placeholder?: string;
  required?: boolean;
  change: (name: string) => void;
}

export function ComponentInput({ label, value, placeholder = 'Ladar(1/0)', required = false, change }: Properties) {
  const console = useConsole();
  const list = useId();
  const addresses = console.fleet.robots.value.flatMap(({ components }) => components.map(({ address }) => address));
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
        {addresses.map((address) => (
          <option key={address} value={nameOf(console, address)} />
        ))}
      </datalist>
    </label>
  );
}
