// The worker of a page: sockets, clock and the session. It runs beside the page, so that a busy page stops neither
// the stick nor the answers.

import { clockOf } from './clock';
import { types } from './header';
import { Session } from './session';
import type { Wire } from './socket';
import type { FromWorker, ToWorker } from './worker_messages';

declare const self: DedicatedWorkerGlobalScope;

const tickTime = 25; // ms

let now = clockOf(performance.timeOrigin);
const post = (message: FromWorker, transfer: Transferable[] = []) => self.postMessage(message, transfer);

// TiMS time: ms since midnight UTC.
const millisecondsOfDay = () => Date.now() % (24 * 3600 * 1000);

let session: Session | undefined;

function wireTo(url: string, name: 'control' | 'data'): Wire {
  let socket: WebSocket | undefined;
  return {
    open() {
      const opened = new WebSocket(url);
      socket = opened;
      opened.binaryType = 'arraybuffer';
      const current = () => socket === opened;
      opened.onopen = () => current() && session?.socket(name).opened(now());
      opened.onmessage = ({ data }) => current() && session?.socket(name).received(new Uint8Array(data), now());
      opened.onclose = ({ code, reason }) => {
        if (!current()) return;
        socket = undefined;
        session?.socket(name).closed(reason || `the connection ended (${code})`, now());
      };
    },
    close() {
      const ended = socket;
      socket = undefined;
      ended?.close();
    },
    send(message) {
      if (socket?.readyState === WebSocket.OPEN) socket.send(message);
    },
    get unsent() {
      return socket?.bufferedAmount ?? 0;
    },
  };
}

function connect(url: string): void {
  session = new Session(
    { control: wireTo(url, 'control'), data: wireTo(url, 'data') },
    (event) => post(event, event.is === 'sample' ? [event.sample.message.buffer] : []),
    Math.random,
    millisecondsOfDay,
  );
  session.tick(now());
  setInterval(() => session?.tick(now()), tickTime);
}

self.onmessage = ({ data }: MessageEvent<ToWorker>) => {
  if (data.do === 'connect') {
    now = clockOf(data.origin);
    return connect(data.url);
  }
  if (session === undefined) return;
  switch (data.do) {
    case 'call':
      return settle(data.id, session.call(data, now()));
    case 'send':
      return session.send(data);
    case 'subscribe':
      return session.subscribe(data.component, data.subscriber, data.period, data.every, now());
    case 'unsubscribe':
      return session.unsubscribe(data.component, data.subscriber, now());
    case 'taken':
      for (const component of data.components) session.taken(component);
      return;
    case 'takeStick':
      return settle(
        data.id,
        session.takeStick(data.address, now()).then(() => answerOf(types.ok)),
      );
    case 'takeSink':
      return settle(
        data.id,
        session.takeSink(data.address, now()).then((taken) => answerOf(taken ? types.ok : types.error)),
      );
    case 'reconnect':
      return session.reconnect(now());
    case 'releaseSink':
      return session.releaseSink();
    case 'releaseStick':
      return session.releaseStick();
    case 'moveStick':
      return session.moveStick(data.position, now());
  }
};

const answerOf = (type: number) => ({ type, flags: 0, body: new Uint8Array() });

function settle(id: number, answer: Promise<{ type: number; flags: number; body: Uint8Array }>): void {
  answer.then(
    (value) => post({ is: 'answer', id, answer: value }),
    (failure) => post({ is: 'failure', id, why: failure.message }),
  );
}
