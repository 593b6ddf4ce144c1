// Where hosts, components and the lines between them are in the graph: a host is a box, its components stand in it
// from left (those that measure) to right (those that use what others measure).

export interface GraphHost {
  name: string;
  level: number; // in the tree of routers, 0: the root
  nodes: string[];
}

export interface GraphEdge {
  from: string; // whose data
  to: string; // who uses them
}

export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface Layout {
  hosts: Map<string, Box>;
  nodes: Map<string, Box>;
  width: number;
  height: number;
}

export const sizes = {
  node: { width: 152, height: 46 },
  gap: { x: 44, y: 12 },
  host: { padding: 16, title: 52, gapX: 28, gapY: 60 },
};

export function layoutGraph(hosts: GraphHost[], edges: GraphEdge[], width: number): Layout {
  const layout: Layout = { hosts: new Map(), nodes: new Map(), width: 0, height: 0 };
  const columnsMax = Math.max(1, Math.floor((width - 2 * sizes.host.padding + sizes.gap.x) / step.x));
  const levels = [...new Set(hosts.map(({ level }) => level))].sort((a, b) => a - b);
  let y = 0;
  for (const level of levels) {
    let x = 0;
    let rowHeight = 0;
    for (const host of hosts.filter((each) => each.level === level)) {
      const columns = columnsOf(host.nodes, edges, columnsMax);
      const size = sizeOf(columns);
      if (x > 0 && x + size.width > width) {
        y += rowHeight + sizes.host.gapY / 2;
        x = 0;
        rowHeight = 0;
      }
      layout.hosts.set(host.name, { x, y, ...size });
      place(columns, x, y, layout.nodes);
      x += size.width + sizes.host.gapX;
      rowHeight = Math.max(rowHeight, size.height);
      layout.width = Math.max(layout.width, x - sizes.host.gapX);
    }
    y += rowHeight + sizes.host.gapY;
  }
  layout.height = Math.max(0, y - sizes.host.gapY);
  return layout;
}

const step = { x: sizes.node.width + sizes.gap.x, y: sizes.node.height + sizes.gap.y };

function sizeOf(columns: string[][]) {
  const rows = Math.max(0, ...columns.map((column) => column.length));
  const inner = Math.max(1, columns.length) * step.x - sizes.gap.x;
  return {
    width: inner + 2 * sizes.host.padding,
    height: sizes.host.title + (rows > 0 ? rows * step.y - sizes.gap.y + sizes.host.padding : 0),
  };
}

function place(columns: string[][], x: number, y: number, nodes: Layout['nodes']): void {
  for (const [i, column] of columns.entries())
    for (const [j, node] of column.entries())
      nodes.set(node, {
        x: x + sizes.host.padding + i * step.x,
        y: y + sizes.host.title + j * step.y,
        ...sizes.node,
      });
}

// A component stands right of all whose data it uses; in a loop, of those that were seen first. Within a column each
// is near its sources.
export function columnsOf(nodes: string[], edges: GraphEdge[], columnsMax: number): string[][] {
  const here = new Set(nodes);
  const sources = new Map(nodes.map((node) => [node, [] as string[]]));
  const used = new Set<string>();
  for (const { from, to } of edges) {
    if (!here.has(from) || !here.has(to) || from === to) continue;
    sources.get(to)?.push(from);
    used.add(from).add(to);
  }
  const ranks = new Map<string, number>();
  const visiting = new Set<string>();
  const rankOf = (node: string): number => {
    const known = ranks.get(node);
    if (known !== undefined) return known;
    visiting.add(node);
    const before = (sources.get(node) ?? []).filter((source) => !visiting.has(source)).map(rankOf);
    visiting.delete(node);
    const rank = before.length > 0 ? Math.max(...before) + 1 : 0;
    ranks.set(node, rank);
    return rank;
  };
  const rankMax = Math.max(0, ...nodes.map(rankOf));
  const columns: string[][] = Array.from({ length: Math.min(rankMax + 1, columnsMax) }, () => []);
  const columnOf = (rank: number) => Math.floor((rank * columns.length) / (rankMax + 1));
  for (const node of nodes) columns[columnOf(rankOf(node))]?.push(node);
  const rows = new Map<string, number>();
  for (const column of columns) {
    const wish = (node: string) => {
      const known = (sources.get(node) ?? []).flatMap((source) => rows.get(source) ?? []);
      if (known.length === 0) return used.has(node) ? 0 : nodes.length; // those alone come last
      return known.reduce((sum, row) => sum + row, 0) / known.length;
    };
    const wishes = new Map(column.map((node) => [node, wish(node)]));
    column.sort((a, b) => wishes.get(a)! - wishes.get(b)!);
    for (const [row, node] of column.entries()) rows.set(node, row);
  }
  return columns;
}

// A curve from the right side of the one to the left side of the other; back to the left, around below.
export function curve(from: Box, to: Box): string {
  const [x1, y1] = [from.x + from.width, from.y + from.height / 2];
  const [x2, y2] = [to.x, to.y + to.height / 2];
  const bend = Math.max(28, Math.min(110, Math.abs(x2 - x1) / 2));
  return `M${x1} ${y1}C${x1 + bend} ${y1} ${x2 - bend} ${y2} ${x2} ${y2}`;
}

// Between two boxes, from the lower side of the upper one.
export function connection(a: Box, b: Box): { path: string; x: number; y: number } {
  const [upper, lower] = a.y <= b.y ? [a, b] : [b, a];
  const besides = lower.y < upper.y + upper.height;
  const start = besides
    ? { x: Math.min(upper.x, lower.x) + (upper.x < lower.x ? upper : lower).width, y: upper.y + 26 }
    : { x: upper.x + Math.min(upper.width, 160) / 2, y: upper.y + upper.height };
  const end = besides
    ? { x: Math.max(upper.x, lower.x), y: lower.y + 26 }
    : { x: lower.x + Math.min(lower.width, 160) / 2, y: lower.y };
  return {
    path: `M${start.x} ${start.y}L${end.x} ${end.y}`,
    x: (start.x + end.x) / 2,
    y: (start.y + end.y) / 2,
  };
}
