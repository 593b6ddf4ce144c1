// The newest sample of each stream on its path to the page. A sample goes out when the page has taken the previous one
// of its stream; until then each newer one replaces it. So a page that is slow, or hidden, holds one message a stream.

import { encodeMessage, flags, types } from './header';

export interface Sample {
  component: number;
  message: Uint8Array<ArrayBuffer>;
  at: number; // arrival, by performance.now() of the page
  received: number; // samples of this stream since it began
  skipped: number; // of these, replaced before the page took them
}

interface Place {
  waiting: Sample | undefined;
  lent: boolean;
  received: number;
  skipped: number;
}

export class NewestSamples {
  private places = new Map<number, Place>();

  constructor(private hand: (sample: Sample) => void) {}

  add(component: number, message: Uint8Array<ArrayBuffer>, at: number): void {
    let place = this.places.get(component);
    if (place === undefined) {
      place = { waiting: undefined, lent: false, received: 0, skipped: 0 };
      this.places.set(component, place);
    }
    ++place.received;
    if (place.waiting !== undefined) ++place.skipped;
    place.waiting = { component, message, at, received: place.received, skipped: place.skipped };
    this.pass(place);
  }

  // A sample has come since the stream began.
  has(component: number): boolean {
    return this.places.has(component);
  }

  taken(component: number): void {
    const place = this.places.get(component);
    if (place === undefined) return;
    place.lent = false;
    this.pass(place);
  }

  forget(component: number): void {
    this.places.delete(component);
  }

  private pass(place: Place): void {
    const sample = place.waiting;
    if (place.lent || sample === undefined) return;
    place.lent = true;
    place.waiting = undefined;
    this.hand(sample);
  }
}

// The answer of a router to the question for the newest value that it keeps of a stream, as the message that passed it,
// with its age in ms. Undefined: it keeps none.
export function keptSample(answer: string): { message: Uint8Array<ArrayBuffer>; age: number } | undefined {
  try {
    const { address, type, age_s: age, little_endian: little, body } = JSON.parse(answer);
    if (type !== types.data || typeof body !== 'string' || typeof age !== 'number' || age < 0) return undefined;
    const pairs = body.match(/[0-9a-f]{2}/g) ?? [];
    if (2 * pairs.length !== body.length) return undefined;
    const message = encodeMessage(
      { type, src: Number(address.raw) },
      Uint8Array.from(pairs, (pair) => Number.parseInt(pair, 16)),
    );
    if (!little) message[0] = (message[0] ?? 0) & ~flags.bodyLittleEndian;
    return { message, age: 1000 * age };
  } catch {
    return undefined;
  }
}
