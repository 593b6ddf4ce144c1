// On all other pages: a change of the configuration that waits for a decision is counted down, whoever made it.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { useConsole } from '../app/console';
import { route } from '../app/route';
import { useNow } from '../ui/connection';
import { pageVisible } from '../ui/use_stream';
import { Agents, type FoundHost } from './agents';
import { type ChangeUnderWay, changesUnderWay } from './apply';
import type { HostState } from './protocol';

const period = 5000; // ms
const walkPeriod = 60_000; // ms between two looks for hosts
const hostsMax = 50; // in a larger fleet, the nearest

export function ChangeWatch() {
  const onStudio = route.value.page === 'studio'; // it has its own
  const { changes, at } = useChanges(pageVisible.value && !onStudio);
  const now = useNow(1000);
  if (onStudio) return null;
  return (
    <>
      {changes.map(({ id, who, why, left, state, hosts }) => (
        <p key={id} class="notice" role="status">
          “{why}” of {who} {state === 'going_back' ? 'is being taken back on' : 'works on'}{' '}
          {hosts.map(({ host }) => host).join(', ')}
          {state === 'waiting' && left !== undefined && (
            <>
              ; without a decision it goes back in <strong>{Math.max(0, Math.ceil(left - (now - at) / 1000))} s</strong>
            </>
          )}
          . <a href="#/studio">Decide in the Studio</a>
        </p>
      ))}
    </>
  );
}

function useChanges(isWanted: boolean): { changes: ChangeUnderWay[]; at: number } {
  const { admin, client } = useConsole();
  const found = useSignal<{ changes: ChangeUnderWay[]; at: number }>({ changes: [], at: 0 });
  useEffect(() => {
    if (!isWanted) return;
    const agents = new Agents(admin);
    let hosts: FoundHost[] = [];
    let walkedAt = Number.NEGATIVE_INFINITY;
    let ended = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const look = async () => {
      const now = performance.now();
      if (now > walkedAt + walkPeriod) {
        hosts = (await agents.hosts()).slice(0, hostsMax);
        walkedAt = now;
      }
      const answers = await Promise.all(
        hosts.map(async (host) => {
          const state = await agents.ask<HostState>(host.agent, { ask: 'conf_state' }, period).catch(() => undefined);
          return { host, state };
        }),
      );
      hosts = answers.filter(({ state }) => state !== undefined).map(({ host }) => host);
      const states = answers.flatMap(({ host, state }) => (state ? { ...state, host: host.name } : []));
      const changes = changesUnderWay(states).filter(({ state }) => state !== 'locked');
      found.value = { changes, at: performance.now() };
    };
    const turn = async () => {
      if (client.connection.value.state === 'connected') await look().catch(() => {});
      if (!ended) timer = setTimeout(turn, period);
    };
    void turn();
    return () => {
      ended = true;
      clearTimeout(timer);
      found.value = { changes: [], at: 0 };
    };
  }, [isWanted]);
  return found.value;
}
