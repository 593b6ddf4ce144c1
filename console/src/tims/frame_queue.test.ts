import assert from 'node:assert/strict';
import { test } from 'node:test';
import { FrameQueue } from './frame_queue';

// A page whose frames begin when a test wants, with items that take a time each.
class Page {
  time = 0;
  taken: number[] = [];
  frames: number[][] = [];
  begin: (() => void) | undefined;
  readonly queue: FrameQueue<number>;

  constructor(cost: number) {
    this.queue = new FrameQueue<number>(
      { now: () => this.time, request: (begin) => (this.begin = begin) },
      (item) => {
        this.taken.push(item);
        this.time += cost;
      },
      (taken) => this.frames.push(taken),
    );
  }

  // The frame begins so long after it was asked for.
  frame(after: number): void {
    this.time += after;
    const begin = this.begin;
    this.begin = undefined;
    begin?.();
  }

  push(...items: number[]): void {
    for (const item of items) this.queue.push(item);
  }
}

test('what came is taken in the next frame, in its order, and not before', () => {
  const page = new Page(0);
  page.push(1, 2, 3);
  assert.deepEqual(page.taken, []);
  page.frame(10);
  assert.deepEqual(page.frames, [[1, 2, 3]]);
  assert.equal(page.begin, undefined, 'no frame is asked for nothing');
  page.push(4);
  page.frame(10);
  assert.deepEqual(page.taken, [1, 2, 3, 4]);
});

test('what a frame has no time for comes first in the next one', () => {
  const page = new Page(2);
  page.push(1, 2, 3, 4, 5);
  page.frame(10);
  assert.deepEqual(page.frames, [[1, 2, 3]]);
  page.push(6);
  page.frame(10);
  assert.deepEqual(page.frames[1], [4, 5, 6]);
});

test('late frames take less, but always one; those in time more again', () => {
  const page = new Page(1);
  const counts: number[] = [];
  const run = (frames: number, after: number) => {
    for (let i = 0; i < frames; ++i) {
      page.push(...Array(5).keys());
      page.frame(after);
      counts.push(page.frames.at(-1)?.length ?? 0);
    }
  };
  run(1, 10);
  assert.equal(counts.at(-1), 5);
  run(20, 26);
  assert.equal(counts.at(-1), 1);
  run(1200, 25);
  assert.equal(counts.at(-1), 5);
});

test('one very late frame, as of a page that was hidden, takes a part of the time only', () => {
  const page = new Page(1);
  page.push(1);
  page.frame(60_000);
  page.push(2, 3, 4, 5, 6, 7);
  page.frame(10);
  assert.deepEqual(page.frames[1], [2, 3, 4]);
});
