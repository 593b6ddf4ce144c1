// Which data flow between components, and which should.

import type { DataEdge } from './protocol';

export interface FlowEdge {
  from: string; // the node whose data it is; of a missing one: its address
  to: string; // the node that uses them
  kind: 'live' | 'planned' | 'extra';
  parameter: string; // that selects it; "" of one that is in no file
  missing: boolean; // nobody has this address
}

// `wanted`: by the files; undefined: they have not been read yet. `byName`, `byAddress`: the nodes of the graph.
// `listeners`: of components, by address.
export function flowEdges(
  wanted: DataEdge[] | undefined,
  byName: ReadonlyMap<string, string>,
  listeners: ReadonlyMap<number, ReadonlySet<number>>,
  byAddress: ReadonlyMap<number, string>,
): FlowEdge[] {
  const live = new Set<string>();
  for (const [producer, users] of listeners)
    for (const user of users) {
      const [from, to] = [byAddress.get(producer), byAddress.get(user)];
      if (from !== undefined && to !== undefined) live.add(`${from}\n${to}`);
    }
  const edges = new Map<string, FlowEdge>();
  for (const { from: user, to: producer, to_host, parameter } of wanted ?? []) {
    const [from, to] = [byName.get(producer) ?? producer, byName.get(user)];
    if (to === undefined) continue;
    const missing = to_host === null;
    const pair = `${from}\n${to}`;
    edges.set(pair, { from, to, kind: missing ? 'extra' : live.has(pair) ? 'live' : 'planned', parameter, missing });
  }
  for (const pair of live) {
    const [from = '', to = ''] = pair.split('\n');
    const kind = wanted === undefined ? 'live' : 'extra';
    if (!edges.has(pair)) edges.set(pair, { from, to, kind, parameter: '', missing: false });
  }
  return [...edges.values()];
}
