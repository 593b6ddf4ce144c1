// A question to the fleet: would a message arrive, and if not, where is it lost, why, and what helps?

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { useConsole, widthsOf } from '../app/console';
import { route, setOption } from '../app/route';
import { useAttempt } from '../ui/attempt';
import { ComponentInput } from '../ui/component_input';
import { type Explanation, explain } from './message_path';

export function ExplainForm() {
  const console = useConsole();
  const to = route.value.options.get('to') ?? '';
  const from = route.value.options.get('from') ?? '';
  const explanation = useSignal<Explanation | undefined>(undefined);
  const { attempt, busy, Failure } = useAttempt();
  const ask = () => {
    explanation.value = undefined;
    void attempt(async () => {
      explanation.value = await explain(console.admin, to, from === '' ? undefined : from, widthsOf(console));
    });
  };
  // Who comes by a link has asked already.
  const isConnected = console.client.connection.value.state === 'connected';
  useEffect(() => {
    if (to !== '' && isConnected) ask();
  }, [isConnected]);
  const submit = (event: Event) => {
    event.preventDefault();
    ask();
  };
  return (
    <>
      <form class="tools" onSubmit={submit}>
        <ComponentInput
          label="From"
          placeholder="this console"
          value={from}
          change={(name) => setOption('from', name)}
        />
        <ComponentInput label="to" required value={to} change={(name) => setOption('to', name)} />
        <button type="submit" class="primary" disabled={busy.value}>
          Explain
        </button>
      </form>
      <Failure />
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
