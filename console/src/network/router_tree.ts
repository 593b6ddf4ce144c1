// The routers of the fleet as a tree, each below the router that it is connected to.
//
// A router knows its neighbours only. So the own one is asked first, then all that it names, and so on: many at a time,
// since one that does not answer must not hide the others. After each answer, what is known by then is published.

import type { RouterItem } from './reports';

export interface TreeRow {
  router: RouterItem;
  depth: number;
  clock: number | undefined; // of the root minus this one's, s
  state: 'asked' | 'up' | 'down';
}

interface Node extends TreeRow {
  below: Node[];
}

export interface Limits {
  routers: number;
  asked: number; // at a time
}

export async function treeOfRouters(
  ask: (address: number) => Promise<RouterItem[]>,
  publish: (rows: () => TreeRow[]) => void,
  limits: Limits = { routers: 2000, asked: 64 },
): Promise<TreeRow[]> {
  const own = await ask(0);
  const self = own.find(({ kind }) => kind === 'self');
  if (self === undefined) return [];
  const seen = new Set([self.address.raw]);
  const root: Node = { router: self, depth: 0, clock: 0, state: 'up', below: [] };
  const waiting = addBelow(root, own, seen, limits.routers);
  publish(() => rowsOf(root));
  const askNext = async () => {
    for (let node = waiting.shift(); node !== undefined; node = waiting.shift()) {
      try {
        const list = await ask(Number(node.router.address.raw));
        const answered = list.find(({ kind }) => kind === 'self');
        if (answered !== undefined)
          node.router = { ...answered, rtt_s: node.router.rtt_s ?? null, since_s: node.router.since_s };
        node.state = 'up';
        waiting.push(...addBelow(node, list, seen, limits.routers));
      } catch {
        node.state = 'down';
      }
      publish(() => rowsOf(root));
    }
  };
  // Who finds nobody waiting ends, while the others' answers may name more: then everybody starts once more.
  while (waiting.length > 0) await Promise.all(Array.from({ length: limits.asked }, askNext));
  return rowsOf(root);
}

// Adds the neighbours that nobody has named before; returns those to be asked.
function addBelow(node: Node, neighbours: RouterItem[], seen: Set<string>, routersMax: number): Node[] {
  const asked: Node[] = [];
  for (const router of neighbours) {
    if (router.kind === 'self' || seen.has(router.address.raw) || seen.size >= routersMax) continue;
    seen.add(router.address.raw);
    const clock = router.clock == null || node.clock === undefined ? undefined : node.clock + router.clock.offset_s;
    const state = router.state === 'up' ? 'asked' : 'down';
    const next: Node = { router, depth: node.depth + 1, clock, state, below: [] };
    node.below.push(next);
    if (state === 'asked') asked.push(next);
  }
  return asked;
}

function rowsOf({ below, ...row }: Node): TreeRow[] {
  return [row, ...below.flatMap(rowsOf)];
}
