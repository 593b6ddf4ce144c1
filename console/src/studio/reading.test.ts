// The studio reads the files of several hosts at once.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Question } from '../model/admin';
import type { Client } from '../tims/client';
import type { Agents } from './agents';

test('hosts that answer at the same time leave each other their files', async () => {
  Object.assign(globalThis, { sessionStorage: { getItem: () => null, setItem: () => {}, removeItem: () => {} } });
  const { Studio } = await import('./studio');
  const waiting = new Map<number, () => void>();
  const answers: Record<string, (agent: number, question: Question) => unknown> = {
    conf_list: () => ({ files: [{ file: 'router.toml', hash: 'h' }], change: {} }),
    conf_get: (agent) => ({ text: `system = ${agent}\n`, hash: 'h', values: { system: agent }, places: {} }),
    conf_options: () => ({ items: [] }),
  };
  const agents = {
    hosts: async () => [1, 2].map((agent) => ({ name: `host${agent}`, router: agent, agent, level: 0, role: 'top' })),
    ask: async (agent: number, question: Question) => {
      const answer = answers[question.ask]?.(agent, question);
      if (answer === undefined) throw new Error(`nobody asks ${question.ask}`);
      if (question.ask === 'conf_get') await new Promise<void>((resolve) => waiting.set(agent, resolve));
      return answer;
    },
  } as unknown as Agents;
  const studio = new Studio({} as Client, agents);
  studio.check = async () => {};
  const refreshed = studio.refresh();
  while (waiting.size < 2) await new Promise((resolve) => setImmediate(resolve));
  for (const [, resolve] of [...waiting].reverse()) {
    resolve();
    await new Promise((resolve) => setImmediate(resolve));
  }
  await refreshed;
  assert.deepEqual([...studio.parsed.value.keys()].sort(), ['host1:router.toml', 'host2:router.toml']);
});
