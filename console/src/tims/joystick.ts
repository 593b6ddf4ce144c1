// The joystick of the console, as a component of class Joystick, like the stick in the original's window: pilots turn
// it on and ask for its data, every 100 ms or faster.
//
// Who moves the stick must go on to say so: without a sign for 250 ms, as when the page is busy or gone, the stick
// springs back to the middle. Zero is sent three times, since it stops a robot.
//
// Pure: time comes in as milliseconds, messages go out as values.

import { type Header, types, wordAt, wordBody } from './header';

export interface StickPosition {
  x: number; // -100 to 100, forward is positive
  y: number; // to the right is positive
  z: number; // sideways, to the right is positive
  buttons: number; // bit n: button n is pressed
}

export interface StickMessage {
  header: Partial<Header>;
  body?: Uint8Array;
}

export const stickAtRest: StickPosition = { x: 0, y: 0, z: 0, buttons: 0 };

const period = 50; // ms
const holdTime = 250;
const zeroRepeats = 3;

interface Listener {
  period: number;
  dueAt: number;
  priority: number;
  sequence: number;
}

export class Joystick {
  private position = stickAtRest;
  private movedAt = Number.NEGATIVE_INFINITY;
  private listeners = new Map<number, Listener>();
  private zeros = 0;

  constructor(
    readonly address: number,
    private clock: () => number, // TiMS time: ms of the day
  ) {}

  move(position: StickPosition, now: number): void {
    this.position = position;
    this.movedAt = now;
    if (!isAtRest(position)) this.zeros = zeroRepeats;
  }

  // A command of another component.
  answer(header: Header, body: Uint8Array, now: number): StickMessage[] {
    const reply = (type: number, content?: Uint8Array): StickMessage[] => [
      {
        header: { type, priority: header.priority, sequence: header.sequence, dest: header.src, src: this.address },
        ...(content && { body: content }),
      },
    ];
    switch (header.type) {
      case types.on:
      case types.off:
        return reply(types.ok);
      case types.getStatus:
        return reply(types.enabled);
      case types.getData:
      case types.getNextData:
        return reply(types.data, this.data(now));
      case types.getContData: {
        const asked = wordAt(body, 0, header.flags);
        const mailbox = wordAt(body, 4, header.flags);
        if (asked === undefined || mailbox === undefined) return reply(types.error);
        const granted = Math.max(period, Math.floor(asked / period) * period);
        this.listeners.set(mailbox, {
          period: granted,
          dueAt: now,
          priority: header.priority,
          sequence: header.sequence,
        });
        return reply(types.contData, wordBody(granted));
      }
      case types.stopContData: {
        const mailbox = wordAt(body, 0, header.flags);
        if (mailbox !== undefined) this.listeners.delete(mailbox);
        return reply(types.ok);
      }
      case types.notAvailable:
        this.listeners.delete(header.src);
        return [];
      default:
        return header.type > 0 ? reply(types.error) : [];
    }
  }

  due(now: number): StickMessage[] {
    const messages: StickMessage[] = [];
    const releasedNow = !isAtRest(this.position) && now >= this.movedAt + holdTime;
    if (releasedNow) this.position = stickAtRest;
    const hurry = isAtRest(this.position) && this.zeros > 0;
    if (hurry) --this.zeros;
    for (const [mailbox, listener] of this.listeners) {
      if (now < listener.dueAt && !hurry) continue;
      listener.dueAt = Math.max(now, listener.dueAt) + listener.period;
      messages.push({
        header: {
          type: types.data,
          flags: reportIfGone,
          priority: listener.priority,
          sequence: listener.sequence,
          dest: mailbox,
          src: this.address,
        },
        body: this.data(now),
      });
    }
    return messages;
  }

  // JoystickData: recordingTime, x, y, z, phi, psi, rho, buttons.
  private data(now: number): Uint8Array {
    if (now >= this.movedAt + holdTime) this.position = stickAtRest;
    const { x, y, z, buttons } = this.position;
    return wordBody(this.clock(), Math.round(x), Math.round(y), Math.round(z), 0, 0, 0, buttons);
  }
}

const reportIfGone = 0x40;

export function isAtRest({ x, y, z, buttons }: StickPosition): boolean {
  return x === 0 && y === 0 && z === 0 && buttons === 0;
}
