// A question to the fleet: would a message arrive, and if not, where is it lost, why, and what helps?

import { useSignal } from '@preact/signals';
import { nameOf, useConsole, widthsOf } from '../app/console';
import { route, setOption } from '../app/route';
import { type Explanation, explain } from './message_path';

export function ExplainForm() {
  const console = useConsole();
  const to = route.value.options.get('to') ?? '';
  const from = route.value.options.get('from') ?? '';
  const explanation = useSignal<Explanation | undefined>(undefined);
  const failure = useSignal('');
  const busy = useSignal(false);
  const names = console.fleet.robots.value.flatMap(({ components }) =>
    components.map(({ address }) => nameOf(console, address)),
  );
  const ask = async (event: Event) => {
    event.preventDefault();
    busy.value = true;
    failure.value = '';
    try {
      explanation.value = await explain(console.admin, to, from === '' ? undefined : from, widthsOf(console));
    } catch (error) {
      explanation.value = undefined;
      failure.value = (error as Error).message;
    }
    busy.value = false;
  };
  return (
    <>
      <form class="tools" onSubmit={ask}>
        <label>
          From{' '}
          <input
            list="components"
            placeholder="this console"
            value={from}
            onInput={(event) => setOption('from', event.currentTarget.value)}
          />
        </label>
        <label>
          to{' '}
          <input
            list="components"
            required
            placeholder="Ladar(1/0)"
            value={to}
            onInput={(event) => setOption('to', event.currentTarget.value)}
          />
        </label>
        <datalist id="components">
          {names.map((name) => (
            <option key={name} value={name} />
          ))}
        </datalist>
        <button type="submit" class="primary" disabled={busy.value}>
          Explain
        </button>
      </form>
      {failure.value !== '' && (
        <p class="bad" role="alert">
          {failure.value}
        </p>
      )}
      {explanation.value !== undefined && <Answer explanation={explanation.value} />}
    </>
  );
}

function Answer({ explanation: { steps, arrives, cause, remedy } }: { explanation: Explanation }) {
  return (
    <div class="explanation" role="status">
      <ol>
        {steps.map(({ router, reason }, i) => (
          <li key={router} class={i + 1 === steps.length && !arrives ? 'bad' : ''}>
            <strong>{router}</strong>
            <span>{reason}</span>
          </li>
        ))}
      </ol>
      <p class={arrives ? 'good' : 'bad'}>
        <strong>{cause}</strong>
      </p>
      {remedy !== '' && <p>{remedy}</p>}
    </div>
  );
}
