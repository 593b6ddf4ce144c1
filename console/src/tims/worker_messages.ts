// What the page and its worker say to each other.

import type { Answer } from './calls';
import type { StickPosition } from './joystick';
import type { SessionEvent } from './session';

export type ToWorker =
  | { do: 'connect'; url: string; origin: number } // performance.timeOrigin of the page, whose clock both have
  | {
      do: 'call';
      id: number;
      dest: number;
      type: number;
      body: Uint8Array;
      timeout: number;
      flags?: number;
      priority?: number;
    }
  | { do: 'send'; dest: number; type: number; body: Uint8Array }
  | { do: 'subscribe'; component: number; subscriber: number; period: number; every: boolean }
  | { do: 'unsubscribe'; component: number; subscriber: number }
  | { do: 'taken'; components: number[] }
  | { do: 'takeStick'; id: number; address: number }
  | { do: 'reconnect' }
  | { do: 'takeSink'; id: number; address: number }
  | { do: 'releaseSink' }
  | { do: 'releaseStick' }
  | { do: 'moveStick'; position: StickPosition };

export type FromWorker =
  | SessionEvent
  | { is: 'answer'; id: number; answer: Answer }
  | { is: 'failure'; id: number; why: string };
