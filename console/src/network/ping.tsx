// How long a router takes to answer this page: over all routers between them.

import { useSignal } from '@preact/signals';
import { useConsole } from '../app/console';
import { useAttempt } from '../ui/attempt';
import { duration } from '../ui/quantities';

const count = 5;

export function Ping({ router }: { router: number }) {
  const { admin } = useConsole();
  const times = useSignal<number[]>([]); // s
  const { attempt, busy, Failure } = useAttempt();
  const ping = async () => {
    times.value = [];
    for (let i = 0; i < count; ++i) {
      const before = performance.now();
      await admin.ask({ ask: 'ping' }, undefined, router);
      times.value = [...times.value, (performance.now() - before) / 1000];
    }
  };
  const found = times.value;
  return (
    <>
      <button type="button" disabled={busy.value} onClick={() => attempt(ping)}>
        Ping
      </button>
      <span role="status">
        {found.length > 0 &&
          `${found.length} answers in ${duration(Math.min(...found))} to ${duration(Math.max(...found))}`}
      </span>
      <Failure />
    </>
  );
}
