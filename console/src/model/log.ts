// The texts of components, the newest last. They come from the logs of the hosts; where no log runs at the own router,
// the console itself is the sink of its texts, like the window of the original. A log also sends the newest texts that
// it has stored, so that one sees what has happened before. A text that repeats itself is folded into one row with its
// number.

import { type ReadonlySignal, signal } from '@preact/signals';
import { className, decodeData, decodeStruct } from '../codec/catalogue';
import type { GdosData } from '../codec/messages';
import { addressOf, addressText, classes, componentOf, type Widths } from '../tims/address';
import type { Client } from '../tims/client';
import { gdosText, type Level, levelOf } from '../tims/gdos';
import { decodeHeader, headerSize } from '../tims/header';
import { command } from './commands';
import type { Fleet } from './fleet';

export interface LogText {
  number: number;
  time: Date; // when the last one arrived
  sender: number; // a component
  level: Level;
  text: string;
  count: number;
}

const textsMax = 30_000;
const retryTime = 5000;

export class Log {
  private readonly textsSignal = signal<LogText[]>([]);
  private readonly isSinkSignal = signal(false);
  private next = 1;
  // Of each component, by level: also of a long log it is known at once why a component is in trouble.
  private newest = new Map<number, Partial<Record<Level, LogText>>>();
  private subscriptions = new Map<number, () => void>(); // by log
  private retry: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly client: Client,
    private readonly fleet: Fleet,
  ) {
    fleet.logs.subscribe((logs) => {
      this.listen(logs);
      void this.beSink();
    });
    client.connection.subscribe(() => void this.beSink());
    client.onText = (sender, type, bits, body) => {
      const widths = this.widths;
      const level = levelOf(type);
      if (widths === undefined || level === undefined) return;
      this.add(
        sender,
        level,
        gdosText(body, bits, (address) => addressText(address, widths, className)),
      );
    };
  }

  get texts(): ReadonlySignal<LogText[]> {
    return this.textsSignal;
  }

  // The texts of this router's components come here and to no log.
  get isSink(): ReadonlySignal<boolean> {
    return this.isSinkSignal;
  }

  clear(): void {
    this.textsSignal.value = [];
    this.newest.clear();
  }

  // The newest text of a component at this level, as long as the log is kept.
  newestOf(component: number, level: Level): LogText | undefined {
    void this.textsSignal.value; // whoever asks is told of changes
    return this.newest.get(component)?.[level];
  }

  private note(text: LogText): void {
    const known = this.newest.get(text.sender) ?? {};
    const before = known[text.level];
    if (before === undefined || before.time <= text.time) known[text.level] = text;
    this.newest.set(text.sender, known);
  }

  private get widths(): Widths | undefined {
    return this.client.connection.value.router?.widths;
  }

  private listen(logs: number[]): void {
    for (const [log, leave] of this.subscriptions)
      if (!logs.includes(log)) {
        leave();
        this.subscriptions.delete(log);
      }
    for (const log of logs)
      if (!this.subscriptions.has(log)) {
        this.subscriptions.set(
          log,
          this.client.subscribe(log, 0, ({ message }) => this.take(message), true),
        );
        void this.takeStored(log).catch(() => {}); // a log of an earlier version cannot
      }
  }

  private async takeStored(log: number): Promise<void> {
    const answer = await command(this.client, { address: log }, 'GDOS.GET_TEXTS');
    const stored = storedTexts(decodeStruct('GdosTexts', answer.body, answer.flags).text);
    const present = this.textsSignal.value;
    const isNew = (old: StoredText) =>
      !present.some(
        ({ sender, level, text }) => sender === this.senderOf(old.mailbox) && level === old.level && text === old.text,
      );
    const added = stored
      .filter(isNew)
      .map(({ time, mailbox, level, text }) => ({ time, sender: this.senderOf(mailbox), level, text, count: 1 }));
    const all = [...added.map((each) => ({ ...each, number: this.next++ })), ...present];
    all.sort((a, b) => a.time.getTime() - b.time.getTime());
    for (const text of all) this.note(text);
    this.textsSignal.value = folded(all).slice(-textsMax);
  }

  private senderOf(mailbox: number): number {
    return this.widths === undefined ? mailbox : componentOf(mailbox, this.widths);
  }

  // A log that is started wants the sink: it tries until the console has let it go.
  private async beSink(): Promise<void> {
    clearTimeout(this.retry);
    const { state, router } = this.client.connection.value;
    const isWanted =
      state === 'connected' && router !== undefined && !this.fleet.logs.value.some((log) => this.fleet.isLocal(log));
    if (!isWanted) {
      this.client.releaseSink();
      this.isSinkSignal.value = false;
      return;
    }
    try {
      const sink = addressOf({ classId: classes.textSink }, router.widths);
      this.isSinkSignal.value = await this.client.takeSink(sink);
    } catch {
      this.isSinkSignal.value = false;
    }
    if (!this.isSinkSignal.value) this.retry = setTimeout(() => void this.beSink(), retryTime);
  }

  private take(message: Uint8Array): void {
    const header = decodeHeader(message);
    if (header === undefined) return;
    const data = decodeData(classes.textSink, message.subarray(headerSize), header.flags) as unknown as GdosData;
    const level = levelOf(data.level);
    if (level !== undefined) this.add(data.sender, level, data.text); // others are the log's signs of life
  }

  private add(mailbox: number, level: Level, text: string): void {
    const sender = this.senderOf(mailbox);
    const texts = this.textsSignal.value;
    const added = { number: this.next++, time: new Date(), sender, level, text, count: 1 };
    this.note(added);
    this.textsSignal.value = [...texts.slice(-textsMax, -1), ...folded([...texts.slice(-1), added])];
  }
}

// The last ones that pass, without looking at all of a long log.
export function lastOf(texts: LogText[], passes: (text: LogText) => boolean, most: number): LogText[] {
  const found: LogText[] = [];
  for (let i = texts.length - 1; i >= 0 && found.length < most; --i) {
    const text = texts[i];
    if (text !== undefined && passes(text)) found.push(text);
  }
  return found.reverse();
}

// Equal neighbours become one.
function folded(texts: LogText[]): LogText[] {
  const rows: LogText[] = [];
  for (const text of texts) {
    const last = rows.at(-1);
    if (last?.sender === text.sender && last.text === text.text && last.level === text.level)
      rows[rows.length - 1] = { ...text, number: last.number, count: last.count + text.count };
    else rows.push(text);
  }
  return rows;
}

interface StoredText {
  time: Date;
  mailbox: number;
  level: Level;
  text: string;
}

// Lines of a log's files; what is none is left out.
function storedTexts(lines: string): StoredText[] {
  return lines.split('\n').flatMap((line) => {
    try {
      const { time, address, level, text } = JSON.parse(line);
      return [{ time: new Date(time), mailbox: Number(address), level, text: `${text}` }];
    } catch {
      return [];
    }
  });
}
