// The box of one value of a file: what is typed is done when it is left, Escape takes it back.

import { useSignal } from '@preact/signals';
import { useLayoutEffect } from 'preact/hooks';
import type { ParameterInfo } from './protocol';

interface Properties {
  label: string;
  info: Pick<ParameterInfo, 'type' | 'choices'>;
  value: string | undefined; // undefined: not in the file
  usual: string;
  invalid?: boolean;
  describedBy?: string;
  change: (text: string) => void;
  pasted?: (text: string) => boolean; // true: taken
  move?: (rows: number) => boolean; // to the box below or above; false: there is none
}

export function ValueInput({ label, info, value, usual, invalid, describedBy, change, pasted, move }: Properties) {
  // What is typed stays while the page is drawn anew, until the file has it, or another value. Not in an effect
  // after the drawing, which could come after the first key.
  const typed = useSignal<string | undefined>(undefined);
  useLayoutEffect(() => {
    typed.value = undefined;
  }, [value]);
  const common = {
    'aria-label': label,
    'aria-invalid': invalid || undefined,
    'aria-describedby': describedBy,
    class: value === undefined ? 'unset' : '',
  };
  if (info.choices !== undefined)
    return (
      <select {...common} value={value ?? ''} onChange={(event) => change(event.currentTarget.value)}>
        <option value="">{usual === '' ? 'not set' : `default: ${choiceText(info, usual)}`}</option>
        {value !== undefined && !info.choices.some((choice) => `${choice.value}` === value) && (
          <option value={value}>{value}</option>
        )}
        {info.choices.map((choice) => (
          <option key={choice.value} value={`${choice.value}`}>
            {choiceText(info, `${choice.value}`)}
          </option>
        ))}
      </select>
    );
  return (
    <input
      {...common}
      inputMode={info.type === 'text' ? 'text' : 'decimal'}
      autocomplete="off"
      spellcheck={false}
      value={typed.value ?? value ?? ''}
      placeholder={usual}
      onInput={(event) => {
        typed.value = event.currentTarget.value;
      }}
      onChange={(event) => {
        if (event.currentTarget.value !== (value ?? '')) change(event.currentTarget.value);
      }}
      onPaste={(event) => {
        if (pasted?.(event.clipboardData?.getData('text/plain') ?? '')) event.preventDefault();
      }}
      onKeyDown={(event) => {
        if (event.key === 'Escape') typed.value = undefined;
        const rows = { ArrowDown: 1, ArrowUp: -1, Enter: 1 }[event.key];
        if (rows !== undefined && move?.(rows)) event.preventDefault(); // else Enter is the end of typing, as anywhere
      }}
    />
  );
}

function choiceText({ choices }: Properties['info'], value: string): string {
  const meaning = choices?.find((choice) => `${choice.value}` === value)?.meaning;
  return meaning === undefined || meaning === value ? value : `${value} ${meaning}`;
}
