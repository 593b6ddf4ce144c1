import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { StickPilot } from './drive';
import { Driver } from './driver';

const pilot = (joystick: number) => ({ joystick }) as StickPilot;

// A robot whose answers come when they are given.
class Played {
  journal: string[] = [];
  answer: () => void = () => {};
  refuse: (why: Error) => void = () => {};
  driver = new Driver({
    begin: ({ joystick }, over) => this.act(`begin ${joystick}${over ? ' over' : ''}`),
    end: ({ joystick }) => this.act(`end ${joystick}`),
  });

  private act(what: string): Promise<void> {
    this.journal.push(what);
    return new Promise((resolve, reject) => {
      this.answer = resolve;
      this.refuse = reject;
    });
  }

  get driven(): number | undefined {
    return this.driver.driven.value?.joystick;
  }

  // Until the next act waits for its answer.
  async answered() {
    this.answer();
    await new Promise((resolve) => setImmediate(resolve));
  }
}

test('it drives with one pilot after the other', async () => {
  const played = new Played();
  void played.driver.begin(pilot(1), false);
  await played.answered();
  await played.answered();
  assert.equal(played.driven, 1);
  void played.driver.begin(pilot(2), true);
  assert.equal(played.driven, undefined, 'neither meanwhile');
  await played.answered();
  await played.answered();
  assert.equal(played.driven, 2);
  played.driver.leave();
  await played.answered();
  assert.deepEqual(played.journal, ['begin 1', 'end 1', 'begin 2 over', 'end 2']);
  assert.equal(played.driven, undefined);
});

test('a page that is left while it begins ends what it has begun', async () => {
  const played = new Played();
  const begun = played.driver.begin(pilot(1), false);
  await new Promise((resolve) => setImmediate(resolve));
  played.driver.leave();
  assert.deepEqual(played.journal, ['begin 1']);
  await played.answered();
  assert.deepEqual(played.journal, ['begin 1', 'end 1']);
  played.answer();
  await begun;
  assert.equal(played.driven, undefined);
});

test('a page that is left while it ends one pilot does not begin with the next', async () => {
  const played = new Played();
  void played.driver.begin(pilot(1), false);
  await played.answered();
  await played.answered();
  const begun = played.driver.begin(pilot(2), false);
  played.driver.leave();
  await played.answered();
  await begun;
  assert.deepEqual(played.journal, ['begin 1', 'end 1']);
});

test('what a robot refuses is thrown, and nothing is driven', async () => {
  const played = new Played();
  const begun = played.driver.begin(pilot(1), false);
  await new Promise((resolve) => setImmediate(resolve));
  played.refuse(new Error('tablet 2 drives it'));
  await assert.rejects(begun, /tablet 2/);
  assert.equal(played.driven, undefined);
  played.driver.leave();
  assert.deepEqual(played.journal, ['begin 1']);
});
