import assert from 'node:assert/strict';
import { afterEach, beforeEach, test } from 'node:test';
import { Client } from './client';
import type { Sample } from './newest';
import type { FromWorker, ToWorker } from './worker_messages';

class FakeWorker {
  posted: ToWorker[] = [];
  onmessage: (event: { data: FromWorker }) => void = () => {};
  onerror: () => void = () => {};
  postMessage(message: ToWorker) {
    this.posted.push(message);
  }
  get taken(): number[] {
    return this.posted.flatMap((message) => (message.do === 'taken' ? message.components : []));
  }
}

const global = globalThis as unknown as {
  requestAnimationFrame: ((draw: () => void) => void) | undefined;
  reportError: ((error: unknown) => void) | undefined;
};
let reported: string[];

beforeEach(() => {
  reported = [];
  global.requestAnimationFrame = (draw) => draw();
  global.reportError = (error) => reported.push((error as Error).message);
});

afterEach(() => {
  global.requestAnimationFrame = undefined;
  global.reportError = undefined;
});

function made() {
  const worker = new FakeWorker();
  return { worker, client: new Client(worker as unknown as Worker, 'ws://router/tims') };
}

const sample = (component: number): FromWorker => ({
  is: 'sample',
  sample: { component, message: new Uint8Array(16), at: 0, received: 1, skipped: 0 },
});

test('the worker gets the clock of the page', () => {
  const { worker } = made();
  assert.deepEqual(worker.posted, [{ do: 'connect', url: 'ws://router/tims', origin: performance.timeOrigin }]);
});

test('a receiver that throws stops neither its stream nor other receivers, and is reported once', () => {
  const { worker, client } = made();
  const got: Sample[] = [];
  client.subscribe(5, 100, () => {
    throw new Error('cannot be decoded');
  });
  client.subscribe(5, 100, (each) => got.push(each));
  for (let i = 0; i < 3; ++i) worker.onmessage({ data: sample(5) });
  assert.equal(got.length, 3);
  assert.deepEqual(worker.taken, [5, 5, 5]);
  assert.deepEqual(reported, ['cannot be decoded']);
});

test('a worker that does not start is a connection that has failed, and no call waits for it', async () => {
  const { worker, client } = made();
  const early = client.call(1, 3);
  worker.onerror();
  assert.equal(client.connection.value.state, 'failed');
  assert.match(client.connection.value.why, /does not start/);
  await assert.rejects(early, /does not start/);
  await assert.rejects(client.takeStick(1), /does not start/);
});

test('an error of a worker that has started ends nothing', () => {
  const { worker, client } = made();
  worker.onmessage({ data: { is: 'rate', bytesPerSecond: 0 } });
  worker.onerror();
  assert.equal(client.connection.value.state, 'connecting');
});
