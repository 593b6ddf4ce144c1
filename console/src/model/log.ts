// The texts of components, as the log of each host passes them on, the newest last. A text that repeats itself is
// folded into one row with its number.

import { type ReadonlySignal, signal } from '@preact/signals';
import { decodeData } from '../codec/catalogue';
import type { GdosData } from '../codec/messages';
import { classes, componentOf } from '../tims/address';
import type { Client } from '../tims/client';
import { decodeHeader, headerSize } from '../tims/header';
import type { Fleet } from './fleet';

export type Level = 'print' | 'error' | 'warning' | 'info' | 'detail';

// As the numbers on the wire.
const levels: Record<number, Level> = {
  [-124]: 'print',
  [-125]: 'error',
  [-126]: 'warning',
  [-127]: 'info',
  [-128]: 'detail',
};

export interface LogText {
  number: number;
  time: Date; // when the last one arrived
  sender: number;
  level: Level;
  text: string;
  count: number;
}

const textsMax = 5000;

export class Log {
  private readonly textsSignal = signal<LogText[]>([]);
  private next = 1;
  private subscriptions = new Map<number, () => void>(); // by log

  constructor(
    private readonly client: Client,
    fleet: Fleet,
  ) {
    fleet.logs.subscribe((logs) => this.listen(logs));
  }

  get texts(): ReadonlySignal<LogText[]> {
    return this.textsSignal;
  }

  clear(): void {
    this.textsSignal.value = [];
  }

  private listen(logs: number[]): void {
    for (const [log, leave] of this.subscriptions)
      if (!logs.includes(log)) {
        leave();
        this.subscriptions.delete(log);
      }
    for (const log of logs)
      if (!this.subscriptions.has(log))
        this.subscriptions.set(
          log,
          this.client.subscribe(log, 0, ({ message }) => this.take(message), true),
        );
  }

  private take(message: Uint8Array): void {
    const header = decodeHeader(message);
    const router = this.client.connection.value.router;
    if (header === undefined || router === undefined) return;
    const data = decodeData(classes.textSink, message.subarray(headerSize), header.flags) as unknown as GdosData;
    const level = levels[data.level];
    if (level === undefined) return; // a sign of life of the log
    this.add({
      number: this.next++,
      time: new Date(),
      sender: componentOf(data.sender, router.widths),
      level,
      text: data.text,
      count: 1,
    });
  }

  private add(text: LogText): void {
    const texts = this.textsSignal.value;
    const last = texts.at(-1);
    const isRepeated = last?.sender === text.sender && last.text === text.text && last.level === text.level;
    this.textsSignal.value = isRepeated
      ? [...texts.slice(0, -1), { ...text, number: last.number, count: last.count + 1 }]
      : [...texts.slice(-textsMax + 1), text];
  }
}
