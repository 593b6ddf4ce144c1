// What pages and views do about commands that can fail.

import { type ReadonlySignal, useComputed, useSignal } from '@preact/signals';
import type { ComponentChildren } from 'preact';
import { useMemo } from 'preact/hooks';
import { AdminError } from '../model/admin';

export interface Attempt {
  attempt: (action: () => Promise<unknown>) => Promise<void>;
  busy: ReadonlySignal<boolean>; // one is under way
  Failure: () => ComponentChildren;
}

// Runs actions, and shows why the last one failed.
export function useAttempt(): Attempt {
  const failure = useSignal('');
  const running = useSignal(0);
  const busy = useComputed(() => running.value > 0);
  return useMemo(
    () => ({
      busy,
      attempt: async (action) => {
        failure.value = '';
        ++running.value;
        try {
          await action();
        } catch (error) {
          failure.value = reasonOf(error as Error);
        }
        --running.value;
      },
      Failure: () =>
        failure.value !== '' && (
          <p class="bad" role="alert">
            {failure.value}
          </p>
        ),
    }),
    [],
  );
}

// The refusal of a router has a hint what to do.
function reasonOf(error: Error): string {
  const hint = error instanceof AdminError ? error.hint : '';
  return hint === '' ? error.message : `${error.message}; ${hint}`;
}
