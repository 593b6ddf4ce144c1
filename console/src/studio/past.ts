// The histories of all hosts as one.

import type { HistoryItem } from './protocol';

export interface PastChange extends Omit<HistoryItem, 'generation' | 'files'> {
  at: { host: string; generation: number; files: string[] }[];
}

// A change on several hosts is one; the newest comes first. Files that are as in the generation before are left out.
export function pastChanges(lists: { host: string; items: HistoryItem[] }[]): PastChange[] {
  const changes = new Map<string, PastChange>();
  for (const { host, items } of lists)
    for (const [i, { generation, files, ...item }] of items.entries()) {
      const before = new Map(items[i + 1]?.files.map(({ file, hash }) => [file, hash]));
      const changed = files.filter(({ file, hash }) => before.get(file) !== hash).map(({ file }) => file);
      const id = item.change || `${host} ${generation}`;
      const known = changes.get(id);
      const at = { host, generation, files: changed };
      if (known === undefined) changes.set(id, { ...item, at: [at] });
      else known.at.push(at);
    }
  return [...changes.values()].sort(newestFirst);
}

// By the numbers of a host that both concern, as clocks may be set.
function newestFirst(a: PastChange, b: PastChange): number {
  for (const { host, generation } of a.at) {
    const other = b.at.find((each) => each.host === host);
    if (other !== undefined) return other.generation - generation;
  }
  return a.time < b.time ? 1 : a.time > b.time ? -1 : 0;
}
