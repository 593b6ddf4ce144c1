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

interface Sizes {
  node: { width: number; height: number };
  gap: { x: number; y: number };
  padding: number;
}

const title = 56; // of a host
const hostGap = { x: 28, y: 64 };
const wide: Sizes = { node: { width: 152, height: 46 }, gap: { x: 44, y: 16 }, padding: 16 };
const narrow: Sizes = { node: { width: 146, height: 46 }, gap: { x: 34, y: 16 }, padding: 10 };
const narrowBelow = 420;
const textHeight = 14; // of a link, above its lower host

export function layoutGraph(hosts: GraphHost[], edges: GraphEdge[], width: number): Layout {
  const layout: Layout = { hosts: new Map(), nodes: new Map(), width: 0, height: 0 };
  const sizes = width < narrowBelow ? narrow : wide;
  const { node, gap, padding } = sizes;
  const columnsMax = Math.max(1, Math.floor((width - 2 * padding + gap.x) / (node.width + gap.x)));
  const levels = [...new Set(hosts.map(({ level }) => level))].sort((a, b) => a - b);
  let y = 0;
  for (const level of levels) {
    let x = 0;
    let rowHeight = 0;
    for (const host of hosts.filter((each) => each.level === level)) {
      const columns = columnsOf(host.nodes, edges, columnsMax);
      const size = sizeOf(columns, sizes);
      if (x > 0 && x + size.width > width) {
        y += rowHeight + hostGap.y / 2;
        x = 0;
        rowHeight = 0;
      }
      layout.hosts.set(host.name, { x, y, ...size });
      place(columns, x, y, sizes, layout.nodes);
      x += size.width + hostGap.x;
      rowHeight = Math.max(rowHeight, size.height);
      layout.width = Math.max(layout.width, x - hostGap.x);
    }
    y += rowHeight + hostGap.y;
  }
  layout.height = Math.max(0, y - hostGap.y);
  return layout;
}

function sizeOf(columns: string[][], { node, gap, padding }: Sizes) {
  const columnHeight = (rows: number, i: number) =>
    rows === 0 ? 0 : rows * (node.height + gap.y) + shift(i, node, gap);
  const inner = Math.max(0, ...columns.map((column, i) => columnHeight(column.length, i)));
  return {
    width: Math.max(1, columns.length) * (node.width + gap.x) - gap.x + 2 * padding,
    height: title + (inner > 0 ? inner - gap.y + padding : 0),
  };
}

// Every second column stands half a row lower, so that a line over it runs between its boxes.
const shift = (column: number, { height }: Sizes['node'], gap: Sizes['gap']) =>
  column % 2 === 1 ? (height + gap.y) / 2 : 0;

function place(columns: string[][], x: number, y: number, { node, gap, padding }: Sizes, nodes: Layout['nodes']): void {
  for (const [i, column] of columns.entries())
    for (const [j, name] of column.entries())
      nodes.set(name, {
        x: x + padding + i * (node.width + gap.x),
        y: y + title + j * (node.height + gap.y) + shift(i, node, gap),
        ...node,
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

// Between two boxes, from the lower side of the upper one; and the place of its text, above the lower one, where no other
// box is.
export function connection(a: Box, b: Box): { path: string; x: number; y: number } {
  const [upper, lower] = a.y <= b.y ? [a, b] : [b, a];
  const besides = lower.y < upper.y + upper.height;
  const start = besides
    ? { x: Math.min(upper.x, lower.x) + (upper.x < lower.x ? upper : lower).width, y: upper.y + 26 }
    : { x: upper.x + Math.min(upper.width, 160) / 2, y: upper.y + upper.height };
  const end = besides
    ? { x: Math.max(upper.x, lower.x), y: lower.y + 26 }
    : { x: lower.x + Math.min(lower.width, 160) / 2, y: lower.y };
  const part = besides ? 0.5 : 1 - textHeight / (end.y - start.y);
  return {
    path: `M${start.x} ${start.y}L${end.x} ${end.y}`,
    x: start.x + part * (end.x - start.x),
    y: start.y + part * (end.y - start.y),
  };
}
