// The state of a component: by colour, by shape and by word.

import type { ComponentState } from '../model/fleet';

const words: Record<ComponentState, string> = {
  unknown: 'not asked yet',
  on: 'on',
  off: 'off',
  error: 'error',
  silent: 'no answer',
};

export function stateWord(state: ComponentState): string {
  return words[state];
}

export function Lamp({ state }: { state: ComponentState }) {
  return (
    <svg class={`lamp lamp-${state}`} viewBox="0 0 12 12" role="img" aria-label={words[state]}>
      <title>{words[state]}</title>
      {state === 'error' ? (
        <path d="M6 .5 11.5 11H.5z" />
      ) : state === 'silent' ? (
        <path d="M1 1h10v10H1z" />
      ) : (
        <circle cx="6" cy="6" r="4.5" />
      )}
    </svg>
  );
}
