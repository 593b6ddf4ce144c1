import assert from 'node:assert/strict';
import { test } from 'node:test';
import { explainedTroubles, injectedFaults, linkTroubles, worst } from './link_health';
import type { LinkItem } from './reports';

const up = {
  state: 'up',
  refusal: null,
  loss_in: 0,
  loss_out: 0,
  queue_delay_s: 0,
  clock: { offset_s: 0, uncertainty_s: 0 },
} as LinkItem;

const healthOf = (change: Partial<LinkItem>) => worst(linkTroubles({ ...up, ...change }));

test('a link that loses nothing is good, and so is a little loss', () => {
  assert.equal(healthOf({}), 'good');
  assert.equal(healthOf({ loss_out: 0.019 }), 'good');
  assert.equal(healthOf({ loss_in: null, loss_out: null, queue_delay_s: null, clock: null }), 'good');
});

test('loss is seen from 2 % on, and grave from 10 % on', () => {
  assert.equal(healthOf({ loss_out: 0.02 }), 'warn');
  assert.equal(healthOf({ loss_in: 0.099 }), 'warn');
  assert.equal(healthOf({ loss_out: 0.1 }), 'bad');
  assert.deepEqual(linkTroubles({ ...up, loss_out: 0.17 }), [
    { health: 'bad', text: '17 % of what is sent to it is lost' },
  ]);
});

test('a line that is too slow, and a wrong clock', () => {
  assert.equal(healthOf({ queue_delay_s: 0.29 }), 'good');
  assert.equal(healthOf({ queue_delay_s: 0.3 }), 'warn');
  assert.match(linkTroubles({ ...up, clock: { offset_s: -90, uncertainty_s: 0 } })[0]?.text ?? '', /1 min 30 s behind/);
  assert.equal(healthOf({ clock: { offset_s: 0.99, uncertainty_s: 0 } }), 'good');
});

test('faults that somebody has injected', () => {
  const faults = { loss: 0.2, duplicate: 0, reorder: 0, delay_s: 0.1, jitter_s: 0, rate: 125000, blackout: false };
  const text = (link: LinkItem) => explainedTroubles(link).map((trouble) => trouble.text);
  const injected = 'Faults are injected into what is sent to it: 20 % lost, 100 ms late, at most 125 kB/s';
  assert.equal(injectedFaults({ ...up, faults: null }), '');
  assert.equal(injectedFaults({ ...up, faults }), injected);
  assert.deepEqual(text({ ...up, faults }), [], 'no trouble by themselves');
  assert.deepEqual(text({ ...up, faults, loss_out: 0.2 }), ['20 % of what is sent to it is lost', injected]);
  assert.deepEqual(text({ ...up, state: 'silent', faults: { ...faults, blackout: true } }), [
    'The link is silent',
    'Faults are injected into what is sent to it: nothing is sent',
  ]);
});

test('a link that is not up says why', () => {
  assert.deepEqual(linkTroubles({ ...up, state: 'silent', loss_out: 0.5 }), [
    { health: 'bad', text: 'The link is silent' },
  ]);
  assert.match(linkTroubles({ ...up, state: 'refused', refusal: 'other widths' })[0]?.text ?? '', /other widths/);
});
