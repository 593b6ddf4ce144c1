// The events of a router, each once, also when a question fails or the router begins anew. Pure.

import type { EventItem } from './reports';

export interface EventList {
  items?: EventItem[];
  last: number;
  lost?: number;
  epoch: string;
}

export interface NewEvents {
  items: EventItem[]; // the newest first
  lost: number;
  isAnew: boolean; // the router was started again: its events are numbered from 1 again
}

type Ask = (question: { ask: 'events' } & Record<string, unknown>, time?: number) => Promise<EventList>;

const wait = 5000; // ms
const backlog = 200;

export class FollowedEvents {
  private at: { last: number; epoch: string } | undefined;

  constructor(private readonly ask: Ask) {}

  // Those since the last call, and the newest of those before the first one. Throws why the router does not answer: the
  // next call goes on where this one would have.
  async next(): Promise<NewEvents> {
    const { last, epoch } = this.at ?? (await this.begin());
    const list = await this.ask({ ask: 'events', since: last, epoch, wait_ms: wait }, 2 * wait);
    this.at = { last: list.last, epoch: list.epoch };
    return { items: [...(list.items ?? [])].reverse(), lost: list.lost ?? 0, isAnew: list.epoch !== epoch };
  }

  private async begin() {
    const { last, epoch } = await this.ask({ ask: 'events' });
    this.at = { last: Math.max(0, last - backlog), epoch };
    return this.at;
  }
}
