// The subscriptions to the data of components, as one page wants them.
//
// A component sends its data to a mailbox that has asked for them with GET_CONT_DATA, at the period that was asked
// for, until STOP_CONT_DATA, or until it goes off: then it sends ERROR to that mailbox, and forgets it. A component
// that is started again has forgotten it as well, without a word. So each subscription is a small state machine: it
// asks, and asks again a second after a refusal and when the stream has been silent for several of its periods.
//
// Several views may want the data of one component at different periods: the shortest is asked for. A view that is
// no longer visible wants nothing; its stream lingers for a moment, since views are often exchanged.
//
// Pure: time comes in as milliseconds, requests go out as values.

export type StreamState = 'asked' | 'flowing' | 'refused' | 'gone';

export interface StreamRequest {
  component: number;
  // In ms; undefined: the stream is to end.
  period: number | undefined;
}

interface Stream {
  wanted: Map<number, number>; // by subscriber: its period in ms
  state: StreamState;
  period: number; // as asked
  granted: number; // as granted
  heardAt: number;
  askAt: number; // when it is asked for (again)
  endAt: number | undefined; // when nobody wants it
}

const answerTime = 1000;
const lingerTime = 1000;
const silentPeriods = 4;
const silentTime = 1500; // in addition

export class StreamRequests {
  private streams = new Map<number, Stream>();

  want(component: number, subscriber: number, period: number, now: number): void {
    const stream = this.streams.get(component);
    if (stream === undefined) {
      this.streams.set(component, {
        wanted: new Map([[subscriber, period]]),
        state: 'asked',
        period,
        granted: period,
        heardAt: now,
        askAt: now,
        endAt: undefined,
      });
      return;
    }
    stream.wanted.set(subscriber, period);
    stream.endAt = undefined;
    this.adjust(stream, now);
  }

  release(component: number, subscriber: number, now: number): void {
    const stream = this.streams.get(component);
    if (!stream?.wanted.delete(subscriber)) return;
    if (stream.wanted.size === 0) stream.endAt = now + lingerTime;
    else this.adjust(stream, now);
  }

  // All mailboxes are new: nobody knows them.
  restart(now: number): void {
    for (const stream of this.streams.values()) this.ask(stream, now);
  }

  granted(component: number, period: number, now: number): void {
    const stream = this.streams.get(component);
    if (stream === undefined) return;
    stream.state = 'flowing';
    stream.granted = period;
    stream.heardAt = now;
    stream.askAt = this.silentAfter(stream, now);
  }

  // The component is off, in error, or has no room; or it is not there.
  refused(component: number, state: 'refused' | 'gone', now: number): void {
    const stream = this.streams.get(component);
    if (stream === undefined) return;
    stream.state = state;
    stream.askAt = now + answerTime;
  }

  sample(component: number, now: number): boolean {
    const stream = this.streams.get(component);
    if (stream === undefined) return false;
    stream.state = 'flowing';
    stream.heardAt = now;
    stream.askAt = this.silentAfter(stream, now);
    return true;
  }

  state(component: number): StreamState | undefined {
    return this.streams.get(component)?.state;
  }

  due(now: number): StreamRequest[] {
    const requests: StreamRequest[] = [];
    for (const [component, stream] of this.streams) {
      if (stream.endAt !== undefined && stream.endAt <= now) {
        this.streams.delete(component);
        requests.push({ component, period: undefined });
      } else if (stream.endAt === undefined && stream.askAt <= now) {
        stream.askAt = now + answerTime;
        requests.push({ component, period: stream.period });
      }
    }
    return requests;
  }

  components(): number[] {
    return [...this.streams.keys()];
  }

  get size(): number {
    return this.streams.size;
  }

  private adjust(stream: Stream, now: number): void {
    const period = Math.min(...stream.wanted.values());
    if (period === stream.period) return;
    stream.period = period;
    this.ask(stream, now);
  }

  private ask(stream: Stream, now: number): void {
    stream.state = 'asked';
    stream.askAt = now;
  }

  private silentAfter(stream: Stream, now: number): number {
    return now + silentPeriods * Math.max(stream.granted, stream.period) + silentTime;
  }
}
