// Whether the router is there: a badge in the bar, and a notice over all pages while it is not.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { useConsole } from '../app/console';
import { askLogin } from '../tims/login';
import { bytes } from './quantities';

export function ConnectionBadge() {
  const { client } = useConsole();
  const { state, router } = client.connection.value;
  const time = client.roundTrip.value;
  if (state !== 'connected')
    return <span class="badge bad">{state === 'connecting' ? 'connecting' : 'not connected'}</span>;
  return (
    <span class="badge" title={`Router ${router?.name}, version ${router?.version}`}>
      <span class="name">{router?.name}</span>
      {time !== undefined && <span class="faint"> {time < 1 ? '<1' : Math.round(time)} ms</span>}
      <span class="faint rate"> {bytes(client.rate.value)}/s</span>
    </span>
  );
}

// What is open to the network. Until a fleet has keys, whoever reaches such a port can do what this page can.
export function ExposedNotice() {
  const { client } = useConsole();
  const { exposed = [], cautions = [] } = client.connection.value.router ?? {};
  return (
    <>
      {exposed.length > 0 && (
        <p class="notice bad exposed">
          Anybody in this network can drive these robots: the router listens beyond its host ({exposed.join(', ')}),
          without keys.
        </p>
      )}
      {cautions.map((text) => (
        <details key={text} class="notice caution">
          <summary>{text.split(': ', 1)}</summary>
          {text}
        </details>
      ))}
    </>
  );
}

export function ConnectionNotice() {
  const { client } = useConsole();
  const { state, since, why } = client.connection.value;
  const now = useNow(1000);
  useEffect(() => {
    if (state === 'lost') void askLogin(); // it may be the login that has ended
  }, [state, why]);
  if (state === 'failed')
    return (
      <p class="notice bad" role="alert">
        No connection to the router: {why}. Load the page again.
      </p>
    );
  if (state !== 'lost') return null;
  return (
    <p class="notice bad" role="alert">
      No connection to the router for {Math.max(0, Math.round((now - since) / 1000))} s: {why}. The values below are
      old; connecting again.
    </p>
  );
}

// performance.now(), renewed at this period in ms.
export function useNow(period: number): number {
  const now = useSignal(performance.now());
  useEffect(() => {
    let timer = setTimeout(turn, period * Math.random()); // not all parts of a page in the same frame
    function turn() {
      now.value = performance.now();
      timer = setTimeout(turn, period);
    }
    return () => clearTimeout(timer);
  }, [period]);
  return now.value;
}
