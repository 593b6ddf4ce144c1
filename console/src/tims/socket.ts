// One connection to the router, without its WebSocket: it asks the router who it is, registers a mailbox there, and
// asks for a sign of life, so that a connection that is dead without a word is found. A lost connection is opened
// again after a pause that grows from 0.2 to 1.5 s.
//
// Pure: time comes in as milliseconds, bytes go out through `wire`.

import { addressOf, classes, fieldsOf, type Widths } from './address';
import { decodeHeader, encodeMessage, type Header, headerSize, routerCommands, types, wordBody } from './header';

export interface RouterInfo {
  name: string;
  address: number;
  epoch: string;
  version: string;
  widths: Widths;
  exposed: string[]; // ports where anybody in the network can drive the robots
  cautions: string[]; // what is allowed there and dangerous
}

export interface Wire {
  open(): void;
  close(): void;
  send(message: Uint8Array<ArrayBuffer>): void;
  readonly unsent: number; // bytes that send() has taken and the line has not
}

export interface SocketEvents {
  ready(router: RouterInfo, mailbox: number, now: number): void;
  lost(why: string, now: number): void;
  // A message that is not for this class.
  message(header: Header, message: Uint8Array<ArrayBuffer>, now: number): void;
  roundTrip(milliseconds: number, now: number): void;
}

type Phase = 'waiting' | 'opening' | 'asking' | 'registering' | 'ready';

const pauseMin = 200;
const pauseMax = 1500;
const setUpTime = 5000;
const pingPeriod = 2000;
const closePingPeriod = 100;
const pingTime = 4000;

export class Socket {
  phase: Phase = 'waiting';
  mailbox = 0;
  private router: RouterInfo | undefined;
  private pause = pauseMin;
  private openAt = 0;
  private deadline = 0;
  private pingAt = 0; // the last one was sent
  private pingSentAt: number | undefined; // it is not answered yet
  private roundTrip = 0;
  private blockedAt: number | undefined; // since when the line has not taken all

  // Signs of life are asked for so often that delay() is known within a tenth of a second.
  isWatched = false;

  constructor(
    private wire: Wire,
    private events: SocketEvents,
    private random: () => number,
    private options = 0, // of its mailbox: keepNewest
  ) {}

  tick(now: number): void {
    if (this.phase === 'waiting') {
      if (now < this.openAt) return;
      this.phase = 'opening';
      this.deadline = now + setUpTime;
      this.wire.open();
    } else if (this.phase === 'ready') {
      if (!this.isBlocked) this.blockedAt = undefined;
      else this.blockedAt ??= now;
      this.ping(now);
    } else if (now >= this.deadline) {
      this.end('the router does not answer', now);
    }
  }

  opened(now: number): void {
    this.phase = 'asking';
    this.deadline = now + setUpTime;
    this.ask('status');
  }

  closed(why: string, now: number): void {
    if (this.phase !== 'waiting') this.lose(why, now);
  }

  received(message: Uint8Array<ArrayBuffer>, now: number): void {
    const header = decodeHeader(message);
    if (header === undefined) return this.end('the router has sent a message of a wrong length', now);
    const ours = header.dest === 0 && header.src === 0 && header.sequence === 0;
    if (!ours) return this.events.message(header, message, now);
    if (header.type === types.adminReply && this.phase === 'asking') return this.introduce(message, now);
    if (this.phase === 'registering') return this.registered(header, now);
    if (header.type === types.adminReply && this.pingSentAt !== undefined) {
      this.roundTrip = now - this.pingSentAt;
      this.events.roundTrip(this.roundTrip, now);
      this.pingSentAt = undefined;
    }
  }

  // What is sent now waits for something that the line has not taken yet.
  get isBlocked(): boolean {
    return this.wire.unsent > 0;
  }

  // For how long, in ms, what is sent now is under way until the router has answered it, as far as is known: the last
  // sign of life took as long, or one is waited for as long, or the line has taken nothing for as long.
  delay(now: number): number {
    return Math.max(this.roundTrip, now - (this.pingSentAt ?? now), now - (this.blockedAt ?? now));
  }

  // Gives the connection up and opens it again.
  restart(now: number): void {
    if (this.phase === 'waiting') return;
    this.phase = 'waiting';
    this.openAt = now + this.pause;
    this.wire.close();
  }

  send(header: Partial<Header>, body?: Uint8Array): void {
    this.wire.send(encodeMessage(header, body));
  }

  private ask(what: string): void {
    this.send({ type: types.adminRequest }, new TextEncoder().encode(JSON.stringify({ ask: what })));
  }

  private introduce(message: Uint8Array<ArrayBuffer>, now: number): void {
    const router = routerInfo(message.subarray(headerSize));
    if (router === undefined) return this.end('the router does not say who it is', now);
    this.router = router;
    this.phase = 'registering';
    this.register(router);
  }

  // A mailbox of a page has an arbitrary instance and local id, so that many pages fit.
  private register({ widths, address }: RouterInfo): void {
    const draw = (bits: number) => Math.floor(this.random() * 2 ** bits);
    this.mailbox = addressOf(
      {
        system: fieldsOf(address, widths).system,
        classId: classes.gui,
        instance: draw(widths.instance),
        local: draw(widths.local),
      },
      widths,
    );
    const body = this.options === 0 ? wordBody(this.mailbox) : wordBody(this.mailbox, this.options);
    this.send({ type: routerCommands.registerMailbox }, body);
  }

  private registered(header: Header, now: number): void {
    if (this.router === undefined) return;
    if (header.type === types.error) return this.register(this.router);
    if (header.type !== types.ok) return;
    this.phase = 'ready';
    this.pause = pauseMin;
    this.pingAt = now;
    this.pingSentAt = undefined;
    this.roundTrip = 0;
    this.blockedAt = undefined;
    this.events.ready(this.router, this.mailbox, now);
  }

  private ping(now: number): void {
    if (this.pingSentAt !== undefined) {
      if (now >= this.pingSentAt + pingTime) this.end('the router does not answer', now);
    } else if (now >= this.pingAt + (this.isWatched ? closePingPeriod : pingPeriod)) {
      this.pingSentAt = now;
      this.pingAt = now;
      this.ask('ping');
    }
  }

  private end(why: string, now: number): void {
    this.wire.close();
    this.lose(why, now);
  }

  private lose(why: string, now: number): void {
    this.phase = 'waiting';
    this.openAt = now + this.pause;
    this.pause = Math.min(2 * this.pause, pauseMax);
    this.events.lost(why, now);
  }
}

function routerInfo(body: Uint8Array): RouterInfo | undefined {
  try {
    const { name, address, epoch, version, widths, security } = JSON.parse(new TextDecoder().decode(body));
    return {
      name: String(name),
      address: Number(address.raw),
      epoch: String(epoch),
      version: String(version),
      exposed: (security?.exposed ?? []).map(String),
      cautions: (security?.cautions ?? []).map(String),
      widths: {
        system: Number(widths[0]),
        classId: Number(widths[1]),
        instance: Number(widths[2]),
        local: Number(widths[3]),
      },
    };
  } catch {
    return undefined;
  }
}
