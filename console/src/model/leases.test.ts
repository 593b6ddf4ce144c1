// Driving leases against routers that are played here.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { signal } from '@preact/signals';
import type { Connection } from '../tims/client';
import { AdminError, type Question } from './admin';
import { fittingName } from './console_name';
import { Leases } from './leases';

const robotRouter = 0x03000100;
const routers = [
  { kind: 'self', role: 'top', system: 0, state: 'up', address: { raw: '0x00000100' } },
  { kind: 'sub', role: 'system', system: 3, state: 'up', address: { raw: '0x03000100' } },
  { kind: 'sub', role: 'system', system: 4, state: 'down', address: { raw: '0x04000100' } },
  { kind: 'missing', role: 'subsystem', system: 5, state: 'down', address: null },
];

const above = [
  { kind: 'self', role: 'top', system: 0, state: 'up', address: { raw: '0x00000100' } },
  { kind: 'sub', role: 'system', system: 3, state: 'up', address: { raw: '0x03000100' } },
  { kind: 'sub', role: 'system', system: 7, state: 'up', address: { raw: '0x07000100' } },
];

class Fixture {
  asked: { question: Question; router: number }[] = [];
  lists: string[] = []; // that were asked for
  isSilent = false;
  routers = routers;
  holders: { robot: number; holder: string; age_s: number }[] = [];
  refusal: AdminError | undefined;
  connection = signal<Connection>({ state: 'connected', router: undefined, since: 0, why: '' });
  leases = new Leases(
    { connection: this.connection },
    {
      ask: async <Answer>(question: Question, _time?: number, router = 0) => {
        this.asked.push({ question, router });
        if (this.refusal !== undefined) throw this.refusal;
        return {} as Answer;
      },
      all: async <Item>(question: Question, router = 0) => {
        this.lists.push(question.ask);
        if (question.ask === 'leases' && this.isSilent)
          throw new AdminError('no_answer', 'the router is not there', '');
        return (question.ask !== 'routers' ? this.holders : router === 0 ? this.routers : above) as Item[];
      },
    },
    signal('tablet 2'),
    (action, period) => {
      assert.equal(period, 1000);
      this.renew = action;
      return () => {
        this.renew = () => {};
      };
    },
  );
  private renew = () => {};

  async pass(seconds: number) {
    for (let second = 0; second < seconds; ++second) {
      this.renew();
      await new Promise((resolve) => setImmediate(resolve));
    }
  }

  done() {
    return this.asked.map(({ question, router }) => `${question.do} ${question.robot} ${router}`);
  }
}

test('a lease is asked of the system router of the robot, else of the own', async () => {
  const fixture = new Fixture();
  await fixture.leases.take(3, { stick: 0x03170000 });
  await fixture.leases.take(4);
  await fixture.leases.take(9, { over: true });
  assert.deepEqual(fixture.done(), [`take 3 ${robotRouter}`, 'take 4 0', 'take_over 9 0']);
  assert.equal(fixture.asked[0]?.question.name, 'tablet 2');
  assert.equal(fixture.asked[0]?.question.stick, '0x03170000');
  assert.deepEqual([...fixture.leases.own.value], [3, 4, 9]);
  for (const robot of [3, 4, 9]) await fixture.leases.release(robot);
  assert.deepEqual(fixture.done().slice(3), [`release 3 ${robotRouter}`, 'release 4 0', 'release 9 0']);
});

test('a robot beside the own is known to the router above', async () => {
  const fixture = new Fixture();
  fixture.routers = [
    { kind: 'self', role: 'system', system: 3, state: 'up', address: { raw: '0x03000100' } },
    { kind: 'super', role: 'top', system: 0, state: 'up', address: { raw: '0x00000100' } },
  ];
  await fixture.leases.take(3);
  await fixture.leases.take(7);
  assert.deepEqual(fixture.done(), ['take 3 0', `take 7 ${0x07000100}`]);
  for (const robot of [3, 7]) await fixture.leases.release(robot);
});

test('who is refused holds nothing', async () => {
  const fixture = new Fixture();
  fixture.refusal = new AdminError('lease_taken', 'desk 1 drives robot 3', '');
  await assert.rejects(fixture.leases.take(3), /desk 1 drives/);
  assert.equal(fixture.leases.own.value.size, 0);
  let ran = false;
  await assert.rejects(
    fixture.leases.during(3, async () => {
      ran = true;
    }),
    /desk 1 drives/,
  );
  assert(!ran);
});

test('a lease is renewed every second, until somebody else has it', async () => {
  const fixture = new Fixture();
  const ends: string[] = [];
  await fixture.leases.take(3, { ended: (why) => ends.push(why) });
  await fixture.pass(2);
  assert.deepEqual(fixture.done().slice(1), [`renew 3 ${robotRouter}`, `renew 3 ${robotRouter}`]);
  fixture.refusal = new AdminError('no_answer', 'the router is not there', '');
  await fixture.pass(1);
  assert.deepEqual(ends, [], 'without an answer it may still be there');
  fixture.refusal = new AdminError('lease_not_held', 'desk 1 drives robot 3', '');
  await fixture.pass(1);
  assert.deepEqual(ends, ['desk 1 drives robot 3']);
  assert.equal(fixture.leases.own.value.size, 0);
  const { length } = fixture.asked;
  await fixture.pass(3);
  assert.equal(fixture.asked.length, length, 'nothing is left to renew');
});

test('a lease ends with the connection', async () => {
  const fixture = new Fixture();
  const ends: string[] = [];
  await fixture.leases.take(3, { ended: (why) => ends.push(why) });
  fixture.connection.value = { ...fixture.connection.value, state: 'lost' };
  assert.deepEqual(ends, ['the connection to the router is lost']);
  assert.equal(fixture.leases.own.value.size, 0);
});

test('a lease for one command ends with it; one that is held stays', async () => {
  const fixture = new Fixture();
  assert.equal(await fixture.leases.during(4, async () => 7), 7);
  await assert.rejects(
    fixture.leases.during(4, async () => {
      throw new Error('refused');
    }),
    /refused/,
  );
  assert.deepEqual(fixture.done(), ['take 4 0', 'release 4 0', 'take 4 0', 'release 4 0']);
  await fixture.leases.take(4);
  await fixture.leases.during(4, async () => {});
  assert.deepEqual(fixture.done().slice(4), ['take 4 0']);
  await fixture.leases.release(4);
});

test('holders are those of the robots that are asked for', async () => {
  const fixture = new Fixture();
  fixture.holders = [
    { robot: 3, holder: 'desk 1', age_s: 1 },
    { robot: 4, holder: 'phone 2', age_s: 1 },
  ];
  const holders = await fixture.leases.holders([3, 5]);
  assert.deepEqual([...holders.keys()], [3]);
  assert.equal(holders.get(3)?.holder, 'desk 1');
});

test('which router is whose is not asked each time', async () => {
  const fixture = new Fixture();
  const asked = () => fixture.lists.filter((list) => list === 'routers').length;
  for (let i = 0; i < 5; ++i) await fixture.leases.holders([3]);
  assert.equal(asked(), 1);
  fixture.isSilent = true;
  await fixture.leases.holders([3]);
  await fixture.leases.holders([3]);
  assert.equal(asked(), 2, 'again when a router did not answer');
  fixture.isSilent = false;
  await fixture.leases.holders([3]);
  assert.equal(asked(), 3);
  fixture.connection.value = { ...fixture.connection.value, state: 'lost' };
  await fixture.leases.holders([3]);
  assert.equal(asked(), 4, 'over another connection');
});

test('a name is cut to what the router takes', () => {
  assert.equal(fittingName('tablet 2'), 'tablet 2');
  assert.equal(fittingName('a'.repeat(40)).length, 31);
  assert.equal(fittingName('ä'.repeat(40)).length, 15);
});
