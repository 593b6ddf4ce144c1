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
  period: number; // that is wanted
  asked: number | undefined; // that was asked for; undefined: nothing was
  granted: number | undefined; // that the component sends at; undefined: it has not answered yet
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
        asked: undefined,
        granted: undefined,
        askAt: now,
        endAt: undefined,
      });
      return;
    }
    stream.wanted.set(subscriber, period);
    stream.endAt = undefined;
    this.adjust(stream);
  }

  release(component: number, subscriber: number, now: number): void {
    const stream = this.streams.get(component);
    if (!stream?.wanted.delete(subscriber)) return;
    if (stream.wanted.size === 0) stream.endAt = now + lingerTime;
    else this.adjust(stream);
  }

  // All mailboxes are new: nobody knows them.
  restart(): void {
    for (const stream of this.streams.values()) {
      stream.state = 'asked';
      stream.asked = undefined;
    }
  }

  granted(component: number, period: number, now: number): void {
    const stream = this.streams.get(component);
    if (stream === undefined) return;
    stream.state = 'flowing';
    stream.granted = period;
    stream.askAt = silentAfter(Math.max(period, stream.period), now);
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
    // Before the answer, it may still be one at the former period.
    if (stream.granted !== undefined) stream.askAt = silentAfter(Math.max(stream.granted, stream.period), now);
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
      } else if (stream.endAt === undefined && (stream.asked !== stream.period || stream.askAt <= now)) {
        stream.asked = stream.period;
        stream.granted = undefined;
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

  private adjust(stream: Stream): void {
    const period = Math.min(...stream.wanted.values());
    if (period === stream.period) return;
    stream.period = period;
    stream.state = 'asked';
  }
}

const silentAfter = (period: number, now: number) => now + silentPeriods * period + silentTime;
