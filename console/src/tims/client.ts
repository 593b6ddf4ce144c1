// TiMS for the page: what its worker knows, as signals, promises and callbacks.

import { type ReadonlySignal, type Signal, signal } from '@preact/signals';
import { className } from '../codec/catalogue';
import { fieldsOf } from './address';
import type { Answer } from './calls';
import { FrameQueue } from './frame_queue';
import { flags, types } from './header';
import type { StickPosition } from './joystick';
import { hindrance } from './login';
import type { Sample } from './newest';
import { neededForType } from './rights';
import type { RouterInfo } from './socket';
import type { StreamRate } from './stream_drops';
import type { StreamState } from './stream_requests';
import type { FromWorker, ToWorker } from './worker_messages';

export interface Connection {
  state: 'connecting' | 'connected' | 'lost' | 'failed'; // failed: until the page is loaded again
  router: RouterInfo | undefined; // the last one
  since: number; // performance.now()
  why: string;
}

export type SampleReceiver = (sample: Sample) => void;

const callTime = 2000;
const reconnectTime = 15_000;
const hopTime = 300; // for records that come later than the answer

interface Pending {
  resolve: (answer: Answer) => void;
  reject: (error: Error) => void;
}

export class Client {
  private readonly connectionSignal = signal<Connection>({
    state: 'connecting',
    router: undefined,
    since: performance.now(),
    why: '',
  });
  private readonly roundTripSignal = signal<number | undefined>(undefined);
  private readonly rateSignal = signal(0);
  readonly stick = signal<number | undefined>(undefined);
  private readonly slowLineSignal = signal(false);
  private readonly states = new Map<number, Signal<StreamState | undefined>>();
  private readonly rates = new Map<number, Signal<StreamRate | undefined>>();
  private readonly receivers = new Map<number, Map<number, SampleReceiver>>();
  private readonly pending = new Map<number, Pending>();
  private readonly samples: FrameQueue<Sample>;
  private readonly broken = new Set<number>(); // streams with a receiver that has thrown
  private isHeard = false; // the worker has begun
  private failure: string | undefined;
  private nextId = 1;
  private onHop: ((record: string) => void) | undefined;

  constructor(
    private readonly worker: Worker,
    url: string,
  ) {
    const frames = { now: () => performance.now(), request: (begin: () => void) => requestAnimationFrame(begin) };
    this.samples = new FrameQueue(
      frames,
      (sample) => this.deliver(sample),
      (delivered) => this.askForNext(delivered),
    );
    worker.onmessage = ({ data }: MessageEvent<FromWorker>) => this.take(data);
    worker.onerror = () => this.fail();
    this.post({ do: 'connect', url, origin: performance.timeOrigin });
  }

  get connection(): ReadonlySignal<Connection> {
    return this.connectionSignal;
  }

  // In ms; undefined: not measured yet, or not connected.
  get roundTrip(): ReadonlySignal<number | undefined> {
    return this.roundTripSignal;
  }

  // What comes from the router, in bytes a second.
  get rate(): ReadonlySignal<number> {
    return this.rateSignal;
  }

  // The router answers so late that the stick rests until it answers faster.
  get slowLine(): ReadonlySignal<boolean> {
    return this.slowLineSignal;
  }

  call(dest: number, type: number, body = new Uint8Array(), timeout = callTime, priority = 0): Promise<Answer> {
    const why = hindrance(neededForType(type, this.classOf(dest)));
    if (why !== '') return Promise.reject(new Error(why));
    return this.answered((id) => ({ do: 'call', id, dest, type, body, timeout, priority }));
  }

  // The records of the routers on the route of a message, in the order of their hops, and whether it was answered.
  async trace(dest: number): Promise<{ hops: string[]; answered: boolean }> {
    const hops: string[] = [];
    this.onHop = (record) => hops.push(record);
    const traced = flags.trace | flags.reportReason;
    const answered = await this.answered((id) => ({
      do: 'call',
      id,
      dest,
      type: types.getStatus,
      body: new Uint8Array(),
      timeout: callTime,
      flags: traced,
    })).then(
      ({ type }) => type !== types.notAvailable,
      () => false,
    );
    await new Promise((resolve) => setTimeout(resolve, hopTime));
    this.onHop = undefined;
    return { hops, answered };
  }

  // Over connections that are made after this call. Throws when there is none in time.
  reconnect(timeout = reconnectTime): Promise<void> {
    return new Promise((resolve, reject) => {
      let lost = false;
      const end = this.connection.subscribe(({ state }) => {
        if (state === 'lost') lost = true;
        if (!lost || state !== 'connected') return;
        clearTimeout(timer);
        queueMicrotask(() => end());
        resolve();
      });
      const timer = setTimeout(() => {
        end();
        reject(new Error('the router cannot be reached by a new connection'));
      }, timeout);
      this.post({ do: 'reconnect' });
    });
  }

  send(dest: number, type: number, body = new Uint8Array()): void {
    this.post({ do: 'send', dest, type, body });
  }

  // Returns what ends the subscription. The receiver gets the newest sample at most once a frame, or, with `every`,
  // each one.
  subscribe(component: number, period: number, receiver: SampleReceiver, every = false): () => void {
    const subscriber = this.nextId++;
    let receivers = this.receivers.get(component);
    if (receivers === undefined) {
      receivers = new Map();
      this.receivers.set(component, receivers);
    }
    receivers.set(subscriber, receiver);
    this.post({ do: 'subscribe', component, subscriber, period, every });
    return () => {
      receivers.delete(subscriber);
      if (receivers.size === 0) this.receivers.delete(component);
      this.post({ do: 'unsubscribe', component, subscriber });
    };
  }

  streamState(component: number): ReadonlySignal<StreamState | undefined> {
    return signalOf(this.states, component);
  }

  // Undefined: the router drops no samples of this stream.
  streamDrops(component: number): ReadonlySignal<StreamRate | undefined> {
    return signalOf(this.rates, component);
  }

  // What the owner of the sink of texts receives.
  onText: ((sender: number, type: number, flags: number, body: Uint8Array) => void) | undefined;

  // False: somebody else is it.
  async takeSink(address: number): Promise<boolean> {
    return (await this.answered((id) => ({ do: 'takeSink', id, address }))).type === types.ok;
  }

  releaseSink(): void {
    this.post({ do: 'releaseSink' });
  }

  async takeStick(address: number): Promise<void> {
    await this.answered((id) => ({ do: 'takeStick', id, address }));
  }

  releaseStick(): void {
    this.post({ do: 'releaseStick' });
  }

  moveStick(position: StickPosition): void {
    this.post({ do: 'moveStick', position });
  }

  private post(message: ToWorker): void {
    this.worker.postMessage(message);
  }

  private answered(message: (id: number) => ToWorker): Promise<Answer> {
    if (this.failure !== undefined) return Promise.reject(new Error(this.failure));
    const id = this.nextId++;
    return new Promise((resolve, reject) => {
      this.pending.set(id, { resolve, reject });
      this.post(message(id));
    });
  }

  // An error of a worker that has begun does not end it: the browser reports it.
  private fail(): void {
    if (this.isHeard) return;
    this.failure = 'a part of this page, its worker, does not start';
    for (const { reject } of this.pending.values()) reject(new Error(this.failure));
    this.pending.clear();
    this.enter('failed', undefined, this.failure);
  }

  private take(event: FromWorker): void {
    this.isHeard = true;
    switch (event.is) {
      case 'connected':
        this.enter('connected', event.router, '');
        break;
      case 'lost':
        this.roundTripSignal.value = undefined;
        if (this.connection.value.state !== 'lost') this.enter('lost', this.connection.value.router, event.why);
        break;
      case 'roundTrip':
        this.roundTripSignal.value = event.milliseconds;
        break;
      case 'rate':
        this.rateSignal.value = event.bytesPerSecond;
        break;
      case 'sample':
        this.samples.push(event.sample);
        break;
      case 'stream':
        signalOf(this.states, event.component).value = event.state;
        break;
      case 'drops':
        signalOf(this.rates, event.component).value = event.rate;
        break;
      case 'hop':
        this.onHop?.(event.record);
        break;
      case 'text':
        this.onText?.(event.sender, event.type, event.flags, event.body);
        break;
      case 'stick':
        this.stick.value = event.address;
        break;
      case 'slowLine':
        this.slowLineSignal.value = event.slow;
        break;
      case 'answer':
        this.settle(event.id)?.resolve(event.answer);
        break;
      case 'failure':
        this.settle(event.id)?.reject(new Error(event.why));
        break;
    }
  }

  private classOf(address: number): string | undefined {
    const { router } = this.connection.value;
    return router && className(fieldsOf(address, router.widths).classId);
  }

  private enter(state: Connection['state'], router: RouterInfo | undefined, why: string): void {
    this.connectionSignal.value = { state, router, since: performance.now(), why };
  }

  private settle(id: number): Pending | undefined {
    const pending = this.pending.get(id);
    this.pending.delete(id);
    return pending;
  }

  private deliver(sample: Sample): void {
    for (const receiver of [...(this.receivers.get(sample.component)?.values() ?? [])])
      try {
        receiver(sample);
      } catch (error) {
        if (!this.broken.has(sample.component)) reportError(error);
        this.broken.add(sample.component);
      }
  }

  // The next ones are asked for when these have been drawn, or cannot be.
  private askForNext(delivered: Sample[]): void {
    const components = delivered.filter(({ received }) => received > 0).map(({ component }) => component);
    if (components.length > 0) this.post({ do: 'taken', components });
  }
}

function signalOf<Value>(signals: Map<number, Signal<Value | undefined>>, key: number): Signal<Value | undefined> {
  let found = signals.get(key);
  if (found === undefined) {
    found = signal<Value | undefined>(undefined);
    signals.set(key, found);
  }
  return found;
}
