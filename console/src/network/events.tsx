// What has happened at the router, as it happens.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { useConsole } from '../app/console';
import { route, setOption } from '../app/route';
import { FilterBox } from '../ui/filter_box';
import { timeText, UtcSwitch } from '../ui/times';
import { askedRouter, RouterChoice } from './asked_router';
import { type EventList, FollowedEvents } from './followed_events';
import type { EventItem } from './reports';

const eventsMax = 500;

export function Events() {
  const { admin } = useConsole();
  const events = useSignal<EventItem[]>([]);
  const lost = useSignal(0);
  const trouble = useSignal('');
  const router = askedRouter();
  const filter = route.value.options.get('filter') ?? '';
  const shown = events.value.filter((event) => matches(event, filter));
  useEffect(() => {
    let ended = false;
    events.value = [];
    lost.value = 0;
    const followed = new FollowedEvents((question, time) => admin.ask<EventList>(question, time, router));
    const follow = async () => {
      while (!ended) {
        const list = await followed.next();
        if (ended) return;
        lost.value += list.lost;
        events.value = [...list.items, ...(list.isAnew ? [] : events.value)].slice(0, eventsMax);
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
  }, [router]);
  return (
    <>
      <div class="tools">
        <RouterChoice />
        <FilterBox
          label="Filter events"
          placeholder="Robot, what or text"
          value={filter}
          change={(text) => setOption('filter', text)}
        />
        <span class="small faint">
          {shown.length} of {events.value.length}
        </span>
        <UtcSwitch />
      </div>
      {trouble.value !== '' && <p class="bad">{trouble.value}</p>}
      {lost.value > 0 && <p class="warn">{lost.value} events were overwritten before they could be shown.</p>}
      <table class="list events">
        <thead>
          <tr>
            <th scope="col">Time</th>
            <th scope="col">What</th>
            <th scope="col">Address</th>
            <th scope="col">Text</th>
          </tr>
        </thead>
        <tbody>
          {shown.map((event) => (
            <tr key={event.seq}>
              <td class="time">{timeText(new Date(event.time))}</td>
              <td>{wordsOf(event)}</td>
              <td>{event.address?.name}</td>
              <td>{event.text ?? event.reason}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </>
  );
}

const wordsOf = ({ kind }: EventItem) => kind.replaceAll('_', ' ');

// All words, in any order.
function matches(event: EventItem, filter: string): boolean {
  const text = `${wordsOf(event)} ${event.address?.name ?? ''} ${event.text ?? event.reason ?? ''}`.toLowerCase();
  return filter
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}
