// The configuration agents of the fleet: which hosts there are, and what they are asked.

import type { Admin, Question } from '../model/admin';
import type { RouterItem } from '../network/reports';

export interface FoundHost {
  name: string;
  router: number; // its address
  agent: number;
  level: number; // in the tree of routers
  role: string;
  above: string | undefined; // the name of its super router
}

const hostsMax = 500;
const agentOffset = 1; // the agent's address is that of its router plus this
const answerTime = 20_000; // ms: a check runs programs to have them describe themselves

export class Agents {
  constructor(private readonly admin: Admin) {}

  ask<Answer>(agent: number, question: Question, timeout = answerTime): Promise<Answer> {
    return this.admin.ask<Answer>(question, timeout, agent);
  }

  // Each router knows its neighbours only. The root is the one without a super router.
  async hosts(): Promise<FoundHost[]> {
    const found = new Map<number, { item: RouterItem; above: number | undefined }>();
    const waiting = [0];
    while (waiting.length > 0 && found.size < hostsMax) {
      const address = waiting.shift()!;
      const list = await this.admin.all<RouterItem>({ ask: 'routers' }, address).catch(() => []);
      const self = list.find(({ kind }) => kind === 'self');
      if (self === undefined) continue;
      const own = Number(self.address.raw);
      if (found.has(own)) continue;
      found.set(own, { item: self, above: numberOf(list.find(({ kind }) => kind === 'super')) });
      for (const router of list)
        if (['super', 'peer', 'sub'].includes(router.kind) && router.state === 'up' && !found.has(numberOf(router)!))
          waiting.push(numberOf(router)!);
    }
    const levelOf = (address: number, depth = 0): number => {
      const above = found.get(address)?.above;
      return above === undefined || !found.has(above) || depth > found.size ? 0 : 1 + levelOf(above, depth + 1);
    };
    return [...found].map(([router, { item, above }]) => ({
      name: item.name ?? item.address.name,
      router,
      agent: router + agentOffset,
      level: levelOf(router),
      role: item.role,
      above: above === undefined ? undefined : (found.get(above)?.item.name ?? undefined),
    }));
  }
}

const numberOf = (router: RouterItem | undefined) => (router === undefined ? undefined : Number(router.address.raw));

export const addressAsText = (address: number) => `0x${address.toString(16).padStart(8, '0')}`;
