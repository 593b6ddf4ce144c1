// Sends a message about which every router on its route reports when it passed, and how long it had waited.

import { useSignal } from '@preact/signals';
import { nameOf, useConsole } from '../app/console';
import { route, setOption } from '../app/route';
import { useAttempt } from '../ui/attempt';
import { ComponentInput } from '../ui/component_input';
import { duration } from '../ui/quantities';
import { timeText, UtcSwitch } from '../ui/times';
import type { HopRecord } from './reports';

interface Result {
  hops: HopRecord[];
  answered: boolean;
}

export function TraceForm() {
  const console = useConsole();
  const to = route.value.options.get('to') ?? '';
  const result = useSignal<Result | undefined>(undefined);
  const { attempt, busy, Failure } = useAttempt();
  const trace = async () => {
    const components = console.fleet.robots.value.flatMap((robot) => robot.components);
    const target = components.find(({ address }) => nameOf(console, address) === to.trim());
    if (target === undefined) throw new Error(`No component ${to} is registered: Explain says why.`);
    const { hops, answered } = await console.client.trace(target.address);
    const records = hops.map((record): HopRecord => JSON.parse(record)).sort((a, b) => a.time.localeCompare(b.time));
    result.value = { hops: records, answered };
  };
  const begin = (event: Event) => {
    event.preventDefault();
    result.value = undefined;
    void attempt(trace);
  };
  return (
    <>
      <form class="tools" onSubmit={begin}>
        <ComponentInput label="To" required value={to} change={(name) => setOption('to', name)} />
        <button type="submit" class="primary" disabled={busy.value}>
          Trace
        </button>
        <UtcSwitch />
      </form>
      <Failure />
      {result.value === undefined && !busy.value && (
        <p class="summary faint">
          Sends one message. Each router on its way reports when it passed, and how long it had waited there.
        </p>
      )}
      {result.value !== undefined && <Hops result={result.value} />}
    </>
  );
}

function Hops({ result: { hops, answered } }: { result: Result }) {
  return (
    <div role="status">
      <table class="list">
        <thead>
          <tr>
            <th scope="col">Time</th>
            <th scope="col">Router</th>
            <th scope="col">From</th>
            <th scope="col">To</th>
            <th scope="col">Waited before</th>
          </tr>
        </thead>
        <tbody>
          {hops.map(({ time, router, from, to, waited_s: waited }) => (
            <tr key={`${time} ${router}`}>
              <td class="time">{timeText(new Date(time)) + time.slice(19, 26)}</td>
              <td>{router}</td>
              <td>{from.name}</td>
              <td>{to.name}</td>
              <td>{duration(waited)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <p class={`summary ${answered ? 'good' : 'bad'}`}>{answered ? 'It was answered.' : 'No answer came.'}</p>
    </div>
  );
}
