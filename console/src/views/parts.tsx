// What several views are made of.

import type { Signal } from '@preact/signals';
import { type ComponentChildren, Fragment } from 'preact';
import { useEffect, useRef } from 'preact/hooks';
import { type Deed, needs } from '../ui/needs';
import { numberIn } from '../ui/quantities';

export function Values({ of }: { of: Record<string, string> }) {
  return (
    <dl class="values">
      {Object.entries(of).map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}

interface HoldProperties {
  deed: Deed;
  action: () => void;
  time?: number; // ms
  disabled?: boolean;
  children: ComponentChildren;
}

// For what moves something by itself: acts when it was held for a moment, by finger, mouse or key. Who still holds it
// when it disappears, or may no longer be pressed, has not done so.
export function HoldButton({ deed, action, time = 700, disabled = false, children }: HoldProperties) {
  const timer = useRef<ReturnType<typeof setTimeout> | undefined>(undefined);
  const begin = () => {
    timer.current ??= setTimeout(action, time);
  };
  const end = () => {
    clearTimeout(timer.current);
    timer.current = undefined;
  };
  useEffect(() => end, []);
  useEffect(() => {
    if (disabled) end();
  }, [disabled]);
  const isPress = ({ key }: KeyboardEvent) => key === 'Enter' || key === ' ';
  return (
    <button
      type="button"
      class="hold"
      {...needs(deed, { disabled, title: 'Hold it for a moment' })}
      onPointerDown={({ button }) => button === 0 && begin()}
      onPointerUp={end}
      onPointerLeave={end}
      onPointerCancel={end}
      onKeyDown={(event) => isPress(event) && !event.repeat && begin()}
      onKeyUp={(event) => isPress(event) && end()}
      onBlur={end}
    >
      {children} <span class="faint small">hold</span>
    </button>
  );
}

interface NumberProperties {
  label: string;
  unit?: string;
  value: Signal<string>;
}

export function NumberInput({ label, unit, value }: NumberProperties) {
  return (
    <label>
      {label}{' '}
      <input
        inputMode="decimal"
        size={7}
        aria-label={unit === undefined ? label : `${label} in ${unit}`}
        value={value}
        onInput={(event) => {
          value.value = event.currentTarget.value;
        }}
      />
      {unit !== undefined && <Fragment> {unit}</Fragment>}
    </label>
  );
}

// Throws a sentence when it is none.
export function numberOf(label: string, { value }: Signal<string>): number {
  const number = numberIn(value);
  if (number === undefined) throw new Error(`${label}: “${value}” is no number`);
  return number;
}

// A canvas whose size is set loses its memory, and gets new: only when its size changes.
export function resize(canvas: HTMLCanvasElement, width: number, height: number): void {
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
}
