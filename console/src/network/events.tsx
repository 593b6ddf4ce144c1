// What has happened at the router, as it happens.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { useConsole } from '../app/console';
import type { EventItem } from './reports';

const eventsMax = 500;
const wait = 5000; // ms
const backlog = 200;

interface EventList {
  items?: EventItem[];
  last: number;
  lost?: number;
  epoch: string;
}

export function Events() {
  const { admin } = useConsole();
  const events = useSignal<EventItem[]>([]);
  const lost = useSignal(0);
  const trouble = useSignal('');
  useEffect(() => {
    let ended = false;
    const follow = async () => {
      let { last, epoch } = await admin.ask<EventList>({ ask: 'events' });
      last = Math.max(0, last - backlog);
      while (!ended) {
        const list = await admin.ask<EventList>({ ask: 'events', since: last, epoch, wait_ms: wait }, 2 * wait);
        ({ last, epoch } = list);
        lost.value += list.lost ?? 0;
        events.value = [...(list.items ?? []).reverse(), ...events.value].slice(0, eventsMax);
        trouble.value = '';
      }
    };
    const retry = async () => {
      while (!ended)
        await follow().catch(async (error: Error) => {
          trouble.value = error.message;
          await new Promise((resolve) => setTimeout(resolve, 1000));
        });
    };
    void retry();
    return () => {
      ended = true;
    };
  }, []);
  return (
    <>
      {trouble.value !== '' && <p class="bad">{trouble.value}</p>}
      {lost.value > 0 && <p class="warn">{lost.value} events were overwritten before they could be shown.</p>}
      <table class="list">
        <thead>
          <tr>
            <th scope="col">Time</th>
            <th scope="col">What</th>
            <th scope="col">Address</th>
            <th scope="col">Text</th>
          </tr>
        </thead>
        <tbody>
          {events.value.map(({ seq, time, kind, address, text, reason }) => (
            <tr key={seq}>
              <td class="time">{new Date(time).toLocaleTimeString('en-GB')}</td>
              <td>{kind.replaceAll('_', ' ')}</td>
              <td>{address?.name}</td>
              <td>{text ?? reason}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </>
  );
}
