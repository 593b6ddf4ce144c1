// A change on several hosts: all or none, and back by itself unless it is confirmed over a connection that was made
// after it.

import type { Edit, HostState } from './protocol';

export interface ApplyTools {
  ask(host: string, question: { ask: string } & Record<string, unknown>): Promise<HostState>;
  reconnect(): Promise<void>;
  pause(milliseconds: number): Promise<void>;
}

export interface Change {
  id: string;
  who: string;
  why: string;
  window: number; // s
  edits: Map<string, Edit[]>; // by host
  agents: Map<string, string>; // the addresses of all agents, as text
  order: string[]; // leaves before their super routers
}

const lockTime = 60; // s
const pollTime = 500; // ms

export function newChangeId(): string {
  return [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, '0')).join('');
}

// Hosts that the order does not name come first.
export function hostsInOrder({ edits, order }: Pick<Change, 'edits' | 'order'>): string[] {
  const place = (host: string) => order.indexOf(host);
  return [...edits.keys()].sort((a, b) => place(a) - place(b));
}

// Throws what hindered it, after it has taken back what was done.
export async function applyChange(tools: ApplyTools, change: Change): Promise<void> {
  const hosts = hostsInOrder(change);
  const { id, who, why, window, edits, agents } = change;
  const locked: string[] = [];
  const applied: string[] = [];
  try {
    for (const host of hosts) {
      await at(host, tools.ask(host, { ask: 'conf_lock', change: id, who, for_s: lockTime }));
      locked.push(host);
    }
    for (const host of hosts) {
      const others = hosts.filter((other) => other !== host).flatMap((other) => agents.get(other) ?? []);
      const question = { ask: 'conf_apply', change: id, who, why, window_s: window, edits: edits.get(host), others };
      applied.push(host); // also when its answer is lost
      await at(host, tools.ask(host, question));
    }
  } catch (error) {
    const take = (host: string, ask: string) => tools.ask(host, { ask, change: id }).catch(() => undefined);
    await Promise.all(applied.map((host) => take(host, 'conf_undo')));
    await Promise.all(locked.filter((host) => !applied.includes(host)).map((host) => take(host, 'conf_unlock')));
    throw error;
  }
}

// Keeps a change for good. Throws when a host is not reached, or does not wait for it any more.
export async function confirmChange(tools: ApplyTools, hosts: string[], id: string): Promise<void> {
  await tools.reconnect();
  const waiting: string[] = [];
  for (const host of hosts) {
    let state = await at(host, tools.ask(host, { ask: 'conf_state' }));
    while (state.state === 'applying' && state.change === id) {
      await tools.pause(pollTime);
      state = await at(host, tools.ask(host, { ask: 'conf_state' }));
    }
    if (state.last?.change === id && state.last.outcome === 'confirmed') continue; // another console was faster
    if (state.change !== id || !['waiting', 'settling'].includes(state.state))
      throw new Error(`${host} has gone back${state.last?.reason ? `: ${state.last.reason}` : ''}`);
    waiting.push(host);
  }
  for (const host of waiting) await at(host, tools.ask(host, { ask: 'conf_confirm', change: id }));
}

async function at<Value>(host: string, value: Promise<Value>): Promise<Value> {
  try {
    return await value;
  } catch (error) {
    throw new Error(`${host}: ${(error as Error).message}`);
  }
}

// --- what the hosts say about it

export interface ChangeUnderWay {
  id: string;
  who: string;
  why: string;
  left: number | undefined; // s, the shortest
  hosts: { host: string; state: HostState['state'] }[];
  state: 'locked' | 'applying' | 'waiting' | 'settling' | 'going_back';
}

// The word that stands for all hosts of a change: what is worst, or not yet done.
const urgency = ['going_back', 'applying', 'waiting', 'settling', 'locked'] as const;

export function changesUnderWay(states: Iterable<HostState>): ChangeUnderWay[] {
  const changes = new Map<string, ChangeUnderWay>();
  for (const { host, state, change, who = '', why = '', left_s: left } of states) {
    if (state === 'idle' || change == null) continue;
    const known = changes.get(change) ?? { id: change, who, why, left: undefined, hosts: [], state };
    known.hosts.push({ host, state });
    if (left !== undefined) known.left = Math.min(known.left ?? left, left);
    if (urgency.indexOf(state) < urgency.indexOf(known.state)) known.state = state;
    changes.set(change, known);
  }
  return [...changes.values()];
}

export interface Ended {
  id: string;
  kept: boolean;
  text: string;
}

// Undefined: a host of the change is not through with it.
export function endOf(id: string, hosts: string[], states: Map<string, HostState>): Ended | undefined {
  const lasts = hosts.map((host) => {
    const state = states.get(host);
    return state?.state === 'idle' && state.last?.change === id ? { host, ...state.last } : undefined;
  });
  if (lasts.length === 0 || lasts.includes(undefined)) return undefined;
  const back = lasts.filter((last) => last?.outcome !== 'confirmed');
  if (back.length === 0) return { id, kept: true, text: `The change is kept on ${hosts.join(', ')}.` };
  const reasons = new Set(back.flatMap((last) => last?.reason ?? []));
  const where =
    back.length === hosts.length ? (hosts.length === 1 ? hosts[0] : 'All hosts') : back.map((l) => l?.host).join(', ');
  return { id, kept: false, text: `${where} went back to the files before the change: ${[...reasons].join('; ')}` };
}
