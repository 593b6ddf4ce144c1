import assert from 'node:assert/strict';
import { test } from 'node:test';
import { type ApplyTools, applyChange, changesUnderWay, confirmChange, endOf, hostsInOrder } from './apply';
import { Changes } from './changes';
import type { HostState } from './protocol';

// Hosts that answer at once, and may refuse a question.
class FakeHosts implements ApplyTools {
  asked: string[] = [];
  reconnects = 0;
  refuse = '';
  states = new Map<string, HostState>();

  constructor(readonly id: string) {}

  async ask(host: string, question: { ask: string } & Record<string, unknown>): Promise<HostState> {
    this.asked.push(`${question.ask} ${host}`);
    if (this.refuse === `${question.ask} ${host}`) throw new Error('refused');
    return this.states.get(host) ?? { host, generation: 1, state: 'waiting', change: this.id };
  }

  async reconnect() {
    ++this.reconnects;
    this.asked.push('reconnect');
  }

  async pause() {
    for (const [host, state] of this.states) this.states.set(host, { ...state, state: 'waiting' });
  }
}

const change = {
  id: '0123456789abcdef',
  who: 'ada',
  why: 'see farther',
  window: 90,
  edits: new Map([
    ['robot1', [{ file: 'router.toml', base: 'a', text: 'b' }]],
    ['arm', [{ file: 'router.toml', base: 'a', text: 'b' }]],
  ]),
  agents: new Map([
    ['robot1', '0x01000101'],
    ['arm', '0x01000201'],
  ]),
  order: ['arm', 'robot1', 'base'],
};

test('all hosts are locked, then changed, leaves first', async () => {
  const hosts = new FakeHosts(change.id);
  await applyChange(hosts, change);
  assert.deepEqual(hosts.asked, ['conf_lock arm', 'conf_lock robot1', 'conf_apply arm', 'conf_apply robot1']);
  assert.deepEqual(hostsInOrder({ edits: change.edits, order: [] }), ['robot1', 'arm']);
});

test('a refusal takes back what was done', async () => {
  const hosts = new FakeHosts(change.id);
  hosts.refuse = 'conf_apply robot1';
  await assert.rejects(applyChange(hosts, change), /robot1: refused/);
  assert.deepEqual(hosts.asked.slice(4).sort(), ['conf_undo arm', 'conf_undo robot1']);
  const locked = new FakeHosts(change.id);
  locked.refuse = 'conf_lock robot1';
  await assert.rejects(applyChange(locked, change));
  assert.deepEqual(locked.asked.slice(2), ['conf_unlock arm']);
});

test('it is confirmed over a new connection, when all hosts wait for it', async () => {
  const hosts = new FakeHosts(change.id);
  hosts.states.set('arm', { host: 'arm', generation: 1, state: 'applying', change: change.id });
  await confirmChange(hosts, ['robot1', 'arm'], change.id);
  assert.equal(hosts.asked[0], 'reconnect');
  assert.deepEqual(hosts.asked.slice(-2), ['conf_confirm robot1', 'conf_confirm arm']);
});

test('it is not confirmed when a host has gone back', async () => {
  const hosts = new FakeHosts(change.id);
  hosts.states.set('arm', { host: 'arm', generation: 1, state: 'idle', change: null });
  await assert.rejects(confirmChange(hosts, ['robot1', 'arm'], change.id), /arm has gone back/);
  assert.ok(!hosts.asked.some((asked) => asked.startsWith('conf_confirm')));
});

const stateOf = (host: string, state: HostState['state'], more: Partial<HostState> = {}): HostState => ({
  host,
  generation: 1,
  state,
  change: 'c',
  who: 'ada',
  why: 'w',
  ...more,
});

test('a change on several hosts is one, with the shortest time', () => {
  const states = [
    stateOf('a', 'waiting', { left_s: 50 }),
    stateOf('b', 'applying', { left_s: 40 }),
    stateOf('d', 'idle'),
    stateOf('e', 'locked', { change: 'other' }),
  ];
  const [first, second] = changesUnderWay(states);
  assert.deepEqual([first?.state, first?.left, first?.hosts.length], ['applying', 40, 2]);
  assert.equal(second?.id, 'other');
});

test('how it ended is known when all its hosts say so', () => {
  const last = (outcome: 'confirmed' | 'went_back') => ({
    generation: 2,
    change: 'c',
    outcome,
    reason: 'time',
    time: '',
  });
  const idle = (host: string, outcome: 'confirmed' | 'went_back') => stateOf(host, 'idle', { last: last(outcome) });
  const states = new Map([
    ['a', idle('a', 'confirmed')],
    ['b', stateOf('b', 'waiting')],
  ]);
  assert.equal(endOf('c', ['a', 'b'], states), undefined);
  states.set('b', idle('b', 'confirmed'));
  assert.equal(endOf('c', ['a', 'b'], states)?.kept, true);
  states.set('b', idle('b', 'went_back'));
  assert.match(endOf('c', ['a', 'b'], states)?.text ?? '', /^b went back.*time/);
  assert.equal(endOf('c', [], states), undefined);
});

test('what was changed from here and went back is offered again, and only that', async () => {
  const hosts = new FakeHosts('c');
  const changes = new Changes(hosts);
  await changes.begin({ ...change, id: 'c' }, [['arm:router.toml', 'b']]);
  assert.ok(changes.isBusy);
  const last = { generation: 2, change: 'c', outcome: 'went_back' as const, reason: 'time', time: '' };
  assert.deepEqual(changes.follow([stateOf('arm', 'waiting'), stateOf('robot1', 'waiting')]), []);
  assert.deepEqual(changes.follow([stateOf('arm', 'idle', { last })]), [], 'robot1 still has it');
  assert.deepEqual(changes.follow([stateOf('robot1', 'idle', { last })]), [['arm:router.toml', 'b']]);
  assert.deepEqual([changes.isBusy, changes.ended.value?.kept], [false, false]);

  const other = new Changes(hosts);
  other.follow([stateOf('arm', 'waiting')]);
  await other.keep('c');
  assert.deepEqual(other.follow([stateOf('arm', 'idle', { last })]), [], 'somebody else has made it');
  assert.throws(() => other.keep('c'), /over/);
});

test('a change that a host refuses is not followed', async () => {
  const hosts = new FakeHosts(change.id);
  hosts.refuse = 'conf_apply robot1';
  const changes = new Changes(hosts);
  await assert.rejects(changes.begin(change, []));
  assert.ok(!changes.isBusy);
});
