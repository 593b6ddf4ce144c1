// A check box with its label, for a signal.

import type { Signal } from '@preact/signals';
import type { ComponentChildren } from 'preact';

export function CheckBox({ checked, children }: { checked: Signal<boolean>; children: ComponentChildren }) {
  return (
    <label>
      <input
        type="checkbox"
        checked={checked.value}
        onChange={(event) => (checked.value = event.currentTarget.checked)}
      />{' '}
      {children}
    </label>
  );
}
