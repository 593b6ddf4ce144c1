// The robots that this browser has seen at a router, and when last. A robot whose programs have all ended, or whose router is
// away for longer than the own one remembers, is missed by nobody else.

import { type ReadonlySignal, signal } from '@preact/signals';

const keptTime = 24 * 3600_000; // ms
const renewTime = 10_000; // ms between two notes of a robot that stays
const robotsMax = 2000;

export class RobotsSeen {
  private readonly timesSignal = signal<ReadonlyMap<number, number>>(new Map());
  private key = '';

  constructor(private readonly storage: Pick<Storage, 'getItem' | 'setItem'>) {}

  // By system: Date.now(), to within some seconds.
  get times(): ReadonlySignal<ReadonlyMap<number, number>> {
    return this.timesSignal;
  }

  // Those that are there now. `router`: the name of the own one.
  note(router: string, systems: number[], now: number): void {
    const key = `rack.seen.${router}`;
    const known = key === this.key ? this.timesSignal.value : read(this.storage.getItem(key));
    const isFresh = (system: number) => (known.get(system) ?? 0) > now - renewTime;
    if (key === this.key && systems.every(isFresh)) return;
    this.key = key;
    const times = new Map([...known].filter(([, time]) => time > now - keptTime));
    for (const system of systems) times.set(system, now);
    this.store(times);
  }

  forget(system: number): void {
    const times = new Map(this.timesSignal.value);
    times.delete(system);
    this.store(times);
  }

  private store(times: Map<number, number>): void {
    const newest = [...times].sort(([, a], [, b]) => b - a).slice(0, robotsMax);
    this.timesSignal.value = new Map(newest);
    this.storage.setItem(this.key, JSON.stringify(newest));
  }
}

function read(text: string | null): Map<number, number> {
  try {
    const times: unknown[] = JSON.parse(text ?? '[]');
    return new Map(times.filter(isTime));
  } catch {
    return new Map();
  }
}

const isTime = (value: unknown): value is [number, number] =>
  Array.isArray(value) && value.length === 2 && value.every((each) => Number.isFinite(each));
