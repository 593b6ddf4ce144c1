// The console's end of TiMS: two connections to the router, since a large message on its way cannot be overtaken
// within one. Commands, their answers and the stick go over `control`, the data of components come over `data`.
//
// The stick is worth nothing when it comes late. While the line has not taken what was sent before, its position is not
// sent: the newest one goes when the line is free. While the router needs more than 0.3 s to answer, the stick rests.
//
// Pure: time comes in as milliseconds, bytes and events go out through what the constructor is given.

import { classId } from '../codec/catalogue';
import { fieldsOf, originalWidths } from './address';
import { type Answer, CallFailure, Calls } from './calls';
import { flags, type Header, headerSize, keepNewest, routerCommands, types, wordAt, wordBody } from './header';
import { Joystick, type StickPosition, stickAtRest } from './joystick';
import { keptSample, NewestSamples, type Sample } from './newest';
import { type RouterInfo, Socket, type Wire } from './socket';
import { StreamDrops, type StreamRate } from './stream_drops';
import { type StreamRequest, StreamRequests, type StreamState } from './stream_requests';

export type SessionEvent =
  | { is: 'connected'; router: RouterInfo; mailbox: number }
  | { is: 'lost'; why: string }
  | { is: 'roundTrip'; milliseconds: number }
  | { is: 'rate'; bytesPerSecond: number }
  | { is: 'sample'; sample: Sample }
  | { is: 'stream'; component: number; state: StreamState }
  | { is: 'stick'; address: number | undefined; why?: string }
  | { is: 'slowLine'; slow: boolean } // the stick rests, whatever moves it
  | { is: 'drops'; component: number; rate: StreamRate | undefined }
  | { is: 'hop'; record: string }
  | { is: 'text'; sender: number; type: number; flags: number; body: Uint8Array };

export interface Request {
  dest: number;
  type: number;
  body: Uint8Array;
  timeout: number; // ms
  flags?: number;
  priority?: number;
}

const registerTime = 2000;
const ratePeriod = 1000; // ms
const questionTime = 2000;
const dropsPeriod = 2000;
const roundTripPeriod = 1000;
const stickDelayMax = 300;

export class Session {
  private control: Socket;
  private data: Socket;
  private calls = new Calls();
  private streams = new StreamRequests();
  private samples: NewestSamples;
  private everySample = new Set<number>();
  private drops = new StreamDrops();
  private dropsAt = 0; // when the router is asked for them
  private joystick: Joystick | undefined;
  private isSlow = false;
  private roundTripAt = 0; // when it was told last
  private sink: number | undefined;
  private connected = false;
  private widths = originalWidths;
  private received = 0; // bytes since ratedAt
  private ratedAt = 0;

  constructor(
    wires: { control: Wire; data: Wire },
    private post: (event: SessionEvent) => void,
    random: () => number,
    private clock: () => number,
  ) {
    const events = (message: (header: Header, bytes: Uint8Array<ArrayBuffer>, now: number) => void) => ({
      ready: (router: RouterInfo, _mailbox: number, now: number) => this.ready(router, now),
      lost: (why: string, now: number) => this.lost(why, now),
      roundTrip: (milliseconds: number, now: number) => this.tellRoundTrip(milliseconds, now),
      message: (header: Header, bytes: Uint8Array<ArrayBuffer>, now: number) => {
        this.received += bytes.length;
        message(header, bytes, now);
      },
    });
    this.control = new Socket(
      wires.control,
      events((header, bytes, now) => this.answered(header, bytes, now)),
      random,
    );
    this.data = new Socket(
      wires.data,
      { ...events((header, bytes, now) => this.sampled(header, bytes, now)), roundTrip: () => {} },
      random,
      keepNewest,
    );
    this.samples = new NewestSamples((sample) => this.post({ is: 'sample', sample }));
  }

  socket(name: 'control' | 'data'): Socket {
    return name === 'control' ? this.control : this.data;
  }

  tick(now: number): void {
    this.control.tick(now);
    this.data.tick(now);
    this.calls.expire(now);
    this.rate(now);
    if (!this.connected) return;
    this.watchLine(now);
    this.sendStick(now);
    for (const request of this.streams.due(now)) this.request(request);
    if (this.streams.size > 0 && now >= this.dropsAt) this.askDrops(now);
  }

  // New connections instead of these: they prove that the router can be reached now.
  reconnect(now: number): void {
    this.lost('connecting anew', now);
  }

  private tellRoundTrip(milliseconds: number, now: number): void {
    if (now < this.roundTripAt + roundTripPeriod) return;
    this.roundTripAt = now;
    this.post({ is: 'roundTrip', milliseconds });
  }

  private rate(now: number): void {
    if (now < this.ratedAt + ratePeriod) return;
    this.post({ is: 'rate', bytesPerSecond: (1000 * this.received) / (now - this.ratedAt) });
    this.received = 0;
    this.ratedAt = now;
  }

  call(request: Request, now: number): Promise<Answer> {
    return new Promise((resolve, reject) => {
      if (!this.connected) return reject(new CallFailure('not connected to the router'));
      const sequence = this.calls.begin(request.dest, now + request.timeout, resolve, reject);
      if (sequence === undefined) return reject(new CallFailure('255 requests to it are under way'));
      const { dest, type, body, priority = 0 } = request;
      const src = dest === 0 ? 0 : this.control.mailbox; // 0 and 0: the own router
      const bits = request.flags ?? flags.reportReason;
      this.control.send({ flags: bits, type, priority, sequence, dest, src }, body);
    });
  }

  // A message that nobody answers.
  send({ dest, type, body }: Omit<Request, 'timeout'>): void {
    if (this.connected) this.control.send({ type, dest, src: this.control.mailbox }, body);
  }

  // `every`: each sample is handed on, not the newest only.
  subscribe(component: number, subscriber: number, period: number, every: boolean, now: number): void {
    if (every) this.everySample.add(component);
    const isNew = this.streams.state(component) === undefined;
    this.streams.want(component, subscriber, period, now);
    if (isNew && !every) this.askNewest(component, now);
    const state = this.streams.state(component);
    if (state !== undefined) this.post({ is: 'stream', component, state });
  }

  unsubscribe(component: number, subscriber: number, now: number): void {
    this.streams.release(component, subscriber, now);
  }

  taken(component: number): void {
    this.samples.taken(component);
  }

  // --- the stick

  async takeStick(address: number, now: number): Promise<void> {
    this.releaseStick();
    const answer = await this.routerCall(routerCommands.registerMailbox, address, now);
    if (answer.type !== types.ok) throw new CallFailure('somebody else has this joystick');
    this.joystick = new Joystick(address, this.clock);
    this.control.isWatched = true;
    this.post({ is: 'stick', address });
  }

  releaseStick(): void {
    if (this.joystick === undefined) return;
    this.control.send({ type: routerCommands.deleteMailbox }, wordBody(this.joystick.address));
    this.dropStick();
  }

  private dropStick(why?: string): void {
    this.joystick = undefined;
    this.control.isWatched = false;
    this.setSlow(false);
    this.post({ is: 'stick', address: undefined, ...(why !== undefined && { why }) });
  }

  moveStick(position: StickPosition, now: number): void {
    this.joystick?.move(this.isSlow ? stickAtRest : position, now);
    this.sendStick(now);
  }

  private sendStick(now: number): void {
    if (this.joystick === undefined || this.control.isBlocked) return;
    for (const { header, body } of this.joystick.due(now)) this.control.send(header, body);
  }

  private watchLine(now: number): void {
    if (this.joystick === undefined) return;
    this.setSlow(this.control.delay(now) > stickDelayMax);
    if (this.isSlow) this.joystick.move(stickAtRest, now);
  }

  private setSlow(slow: boolean): void {
    if (slow === this.isSlow) return;
    this.isSlow = slow;
    this.post({ is: 'slowLine', slow });
  }

  // The mailbox that all components send their texts to. One owner at a router: false if somebody else has it.
  async takeSink(address: number, now: number): Promise<boolean> {
    if (this.sink === address) return true;
    const answer = await this.routerCall(routerCommands.registerMailbox, address, now);
    if (answer.type === types.ok) this.sink = address;
    return answer.type === types.ok;
  }

  releaseSink(): void {
    if (this.sink === undefined) return;
    this.control.send({ type: routerCommands.deleteMailbox }, wordBody(this.sink));
    this.sink = undefined;
  }

  private routerCall(type: number, address: number, now: number): Promise<Answer> {
    return new Promise((resolve, reject) => {
      if (!this.connected) return reject(new CallFailure('not connected to the router'));
      const sequence = this.calls.begin(0, now + registerTime, resolve, reject);
      if (sequence === undefined) return reject(new CallFailure('255 requests to the router are under way'));
      this.control.send({ type, sequence }, wordBody(address));
    });
  }

  // --- what the router knows of streams

  private async ask(question: object, now: number): Promise<string> {
    const body = new TextEncoder().encode(JSON.stringify(question));
    const answer = await this.call({ dest: 0, type: types.adminRequest, body, timeout: questionTime }, now);
    return new TextDecoder().decode(answer.body);
  }

  // A view that opens shows what the router has kept, with its age, until the first sample comes.
  private askNewest(component: number, now: number): void {
    this.ask({ ask: 'newest', of: hex(component) }, now).then(
      (answer) => {
        const kept = keptSample(answer);
        if (kept === undefined || this.streams.state(component) === undefined) return;
        if (this.samples.has(component)) return;
        const at = now - kept.age;
        this.post({ is: 'sample', sample: { component, message: kept.message, at, received: 0, skipped: 0 } });
      },
      () => {}, // the stream itself says what is wrong
    );
  }

  private askDrops(now: number): void {
    this.dropsAt = now + dropsPeriod;
    this.ask({ ask: 'streams', to: hex(this.data.mailbox) }, now).then(
      (answer) => {
        for (const { component, rate } of this.drops.update(answer, now)) this.post({ is: 'drops', component, rate });
      },
      () => {},
    );
  }

  // --- what comes

  private ready(router: RouterInfo, now: number): void {
    if (this.control.phase !== 'ready' || this.data.phase !== 'ready') return;
    this.connected = true;
    this.widths = router.widths;
    this.streams.restart();
    this.drops.restart();
    for (const component of this.streams.components())
      if (!this.everySample.has(component)) this.askNewest(component, now);
    this.post({ is: 'connected', router, mailbox: this.control.mailbox });
  }

  private lost(why: string, now: number): void {
    if (!this.connected) return this.post({ is: 'lost', why });
    this.connected = false;
    this.sink = undefined;
    this.calls.fail(`the connection to the router is lost: ${why}`);
    if (this.joystick !== undefined) this.dropStick('the connection is lost');
    // Neither goes on without the other: the streams' receiver and their sender's partner are one console.
    for (const socket of [this.control, this.data]) socket.restart(now);
    this.post({ is: 'lost', why });
  }

  private answered(header: Header, message: Uint8Array<ArrayBuffer>, now: number): void {
    const body = message.subarray(headerSize);
    if (header.dest === this.joystick?.address) {
      for (const reply of this.joystick.answer(header, body, now)) this.control.send(reply.header, reply.body);
      return;
    }
    if (header.dest === this.sink) {
      this.post({ is: 'text', sender: header.src, type: header.type, flags: header.flags, body });
      return;
    }
    if (header.type === types.hopRecord) return this.post({ is: 'hop', record: new TextDecoder().decode(body) });
    const answer = { type: header.type, flags: header.flags, body };
    if (this.calls.answer(header.src, header.sequence, answer)) return;
    if (header.type === types.data) return this.sampled(header, message, now);
    this.streamAnswered(header, body, now);
  }

  // Requests for streams are not calls: they are repeated until they succeed.
  private streamAnswered(header: Header, body: Uint8Array, now: number): void {
    const before = this.streams.state(header.src);
    if (header.type === types.contData) this.streams.granted(header.src, wordAt(body, 0, header.flags) ?? 0, now);
    else if (header.type === types.notAvailable) this.streams.refused(header.src, 'gone', now);
    else if (header.type === types.error) this.streams.refused(header.src, 'refused', now);
    this.report(header.src, before);
  }

  private sampled(header: Header, message: Uint8Array<ArrayBuffer>, now: number): void {
    const before = this.streams.state(header.src);
    if (header.type === types.data) {
      if (!this.streams.sample(header.src, now)) return;
      if (this.everySample.has(header.src))
        this.post({
          is: 'sample',
          sample: { component: header.src, message, at: now, received: 0, skipped: 0 },
        });
      else this.samples.add(header.src, message, now);
    } else if (header.type === types.error) {
      this.streams.refused(header.src, 'refused', now);
    }
    this.report(header.src, before);
  }

  private report(component: number, before: StreamState | undefined): void {
    const state = this.streams.state(component);
    if (state !== undefined && state !== before) this.post({ is: 'stream', component, state });
  }

  private priorityOf(component: number): number {
    const { classId: kind } = fieldsOf(component, this.widths);
    return bulky.includes(kind) ? bulkyPriority : streamPriority;
  }

  private request({ component, period }: StreamRequest): void {
    const src = this.control.mailbox;
    // The other mailbox keeps the newest only.
    const { mailbox } = this.everySample.has(component) ? this.control : this.data;
    if (period === undefined) {
      this.samples.forget(component);
      this.everySample.delete(component);
      this.control.send({ type: types.stopContData, dest: component, src }, wordBody(mailbox));
      return;
    }
    this.control.send(
      { type: types.getContData, dest: component, src, priority: this.priorityOf(component) },
      wordBody(period, mailbox),
    );
  }
}

// Pictures and maps wait for everything else on a line that is short of bandwidth.
const bulky = ['Camera', 'GridMap', 'Scan3d'].map(classId);
const bulkyPriority = 0;
const streamPriority = 1;

const hex = (address: number) => `0x${address.toString(16).padStart(8, '0')}`;
