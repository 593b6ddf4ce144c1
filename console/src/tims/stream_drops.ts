// How many samples of each stream the router drops on their way to this page, because the line is slower than the
// stream: a newer sample replaces one that waits. From two answers of the router, a moment apart. Pure.

export interface StreamRate {
  samples: number; // a second, that came for the page
  dropped: number; // a second, of these
}

interface Item {
  from: { raw: string };
  samples: number;
  dropped: number;
}

export class StreamDrops {
  private last = new Map<number, Item>();
  private reported = new Set<number>();
  private at = 0;

  // The counts of a router begin anew with the connection.
  restart(): void {
    this.last.clear();
  }

  // The streams of which samples are dropped, and those of which none are any longer.
  update(answer: string, now: number): { component: number; rate: StreamRate | undefined }[] {
    const items = itemsOf(answer);
    if (items === undefined) return [];
    const seconds = (now - this.at) / 1000;
    this.at = now;
    const changes: { component: number; rate: StreamRate | undefined }[] = [];
    const dropping = new Set<number>();
    const counts = new Map<number, Item>();
    for (const item of items) {
      const component = Number(item.from.raw);
      counts.set(component, item);
      const before = this.last.get(component);
      if (before === undefined || item.dropped <= before.dropped) continue;
      dropping.add(component);
      const rate = (count: 'samples' | 'dropped') => (item[count] - before[count]) / seconds;
      changes.push({ component, rate: { samples: rate('samples'), dropped: rate('dropped') } });
    }
    for (const component of this.reported) if (!dropping.has(component)) changes.push({ component, rate: undefined });
    this.last = counts;
    this.reported = dropping;
    return changes;
  }
}

function itemsOf(answer: string): Item[] | undefined {
  try {
    const { items } = JSON.parse(answer);
    return Array.isArray(items) ? items : undefined;
  } catch {
    return undefined;
  }
}
