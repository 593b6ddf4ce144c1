// The changes that were made: who, when and why; and the way back to any of them.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { dateText, UtcSwitch } from '../ui/times';
import { type PastChange, pastChanges } from './past';
import { show } from './place';
import type { Outcome } from './protocol';
import { useStudio } from './workshop';

const outcomeWords: Record<Outcome, string> = {
  pending: 'waits for a decision',
  confirmed: 'kept',
  went_back: 'went back',
  found: 'edited by hand',
};

export function HistoryView() {
  const { studio } = useStudio();
  const changes = useSignal<PastChange[] | undefined>(undefined);
  const generations = studio.hosts.value.map(({ list }) => list?.generation).join();
  useEffect(() => {
    studio.history().then(
      (lists) => (changes.value = pastChanges(lists)),
      (error: Error) => (studio.failure.value = error.message),
    );
  }, [generations]);
  if (changes.value === undefined) return <p class="empty faint">Asking the hosts …</p>;
  if (changes.value.length === 0)
    return (
      <section class="empty">
        <h2>No change has been made yet</h2>
        <p>The newest 20 of each host are kept here.</p>
      </section>
    );
  const goBack = async ({ why, at }: PastChange) => {
    if (await studio.goBackTo(`Back to “${why}”`, at)) show({ view: 'changes' });
  };
  return (
    <>
      <div class="tools">
        <UtcSwitch />
      </div>
      <ol class="history">
        {changes.value.map((change) => (
          <li key={change.at.map(({ host, generation }) => `${host} ${generation}`).join()} class="box">
            <h2>{change.why || outcomeWords[change.outcome]}</h2>
            <p>
              <time dateTime={change.time}>{dateText(new Date(change.time))}</time>
              {change.who !== '' && `, by ${change.who}`}
              {', '}
              <strong class={change.outcome === 'went_back' ? 'bad' : ''}>{outcomeWords[change.outcome]}</strong>
              {change.reason && `: ${change.reason}`}
            </p>
            <p class="faint">
              {change.at
                .map(({ host, generation, files }) => `${host} (${generation}): ${files.join(', ') || 'no file'}`)
                .join('; ')}
            </p>
            {change.outcome !== 'went_back' && (
              <p class="actions">
                <button type="button" onClick={() => void goBack(change)}>
                  Go back to this<span class="hidden">: {change.why || outcomeWords[change.outcome]}</span>
                </button>
              </p>
            )}
          </li>
        ))}
      </ol>
    </>
  );
}
