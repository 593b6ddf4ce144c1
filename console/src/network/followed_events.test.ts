import assert from 'node:assert/strict';
import { test } from 'node:test';
import { type EventList, FollowedEvents } from './followed_events';
import type { EventItem } from './reports';

// A router with so many events, in this epoch.
class Router {
  count = 0;
  epoch = 'a';
  isAway = false;

  ask = async ({ since, epoch }: Record<string, unknown>): Promise<EventList> => {
    if (this.isAway) throw new Error('no answer');
    if (since === undefined) return { last: this.count, epoch: this.epoch };
    const first = epoch === this.epoch ? Number(since) : 0;
    const items = Array.from({ length: this.count - first }, (_, i) => ({ seq: first + i + 1 }) as EventItem);
    return { items, last: this.count, epoch: this.epoch };
  };
}

const numbers = ({ items }: { items: EventItem[] }) => items.map(({ seq }) => seq);

test('each event comes once, also after a question without an answer', async () => {
  const router = new Router();
  router.count = 3;
  const followed = new FollowedEvents(router.ask);
  assert.deepEqual(numbers(await followed.next()), [3, 2, 1]);
  router.isAway = true;
  await assert.rejects(followed.next(), /no answer/);
  router.isAway = false;
  router.count = 4;
  assert.deepEqual(numbers(await followed.next()), [4]);
});

test('a router that was started again counts from 1', async () => {
  const router = new Router();
  router.count = 3;
  const followed = new FollowedEvents(router.ask);
  assert.equal((await followed.next()).isAnew, false);
  router.epoch = 'b';
  router.count = 2;
  const { isAnew, ...list } = await followed.next();
  assert.deepEqual([isAnew, numbers(list)], [true, [2, 1]]);
});

test('of what was before, the newest 200 are shown', async () => {
  const router = new Router();
  router.count = 1000;
  assert.equal((await new FollowedEvents(router.ask).next()).items.length, 200);
});
