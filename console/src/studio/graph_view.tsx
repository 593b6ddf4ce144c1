// The fleet as a graph: hosts as boxes with their components, the data that flow between these, and the links between
// the hosts. Beside it the form of what was chosen.

import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { nameOf, useConsole, widthsOf } from '../app/console';
import { Lamp, stateWord } from '../ui/lamp';
import { bytes, percent } from '../ui/quantities';
import { pageVisible } from '../ui/use_stream';
import { addressNameOf, type PlannedComponent } from './components';
import { fileOf, keyOf } from './draft';
import { type FlowEdge, flowEdges } from './flow';
import { Inspector } from './inspector';
import { connection, curve, type Layout, layoutGraph } from './layout';
import { addressOfPlanned, liveOf } from './live';
import { nodeId, option, show } from './place';
import type { LinkBudget } from './protocol';
import type { Host, Studio } from './studio';
import { useStudio } from './workshop';

const period = 4000; // ms between two questions for listeners

export function GraphView() {
  return (
    <div class={`graph-view ${option('at') === undefined ? '' : 'chosen'}`}>
      <Graph />
      <Inspector />
    </div>
  );
}

function Graph() {
  const { studio } = useStudio();
  const box = useRef<HTMLDivElement>(null);
  const width = useSignal(0);
  useEffect(() => {
    const observer = new ResizeObserver(([entry]) => {
      width.value = Math.floor(entry?.contentRect.width ?? 0);
    });
    if (box.current !== null) observer.observe(box.current);
    return () => observer.disconnect();
  }, []);
  const robots = robotsOf(studio);
  const robot = option('robot');
  const hosts = studio.hosts.value.filter((host) => robot === undefined || `${host.list?.router.system}` === robot);
  const names = new Set(hosts.map(({ name }) => name));
  const components = studio.components.value.filter(({ host }) => names.has(host));
  const edges = useFlow(components);
  const layout = layoutGraph(
    hosts.map(({ name, level }) => ({
      name,
      level,
      nodes: components.filter(({ host }) => host === name).map(nodeId),
    })),
    edges.filter(({ kind }) => kind !== 'extra'),
    Math.max(width.value, 190),
  );
  return (
    <section class="graph" aria-label="Hosts and components">
      <div class="graph-tools">
        {robots.length > 2 && (
          <label>
            Show{' '}
            <select value={robot ?? ''} onChange={(event) => show({ robot: event.currentTarget.value || undefined })}>
              <option value="">all hosts</option>
              {robots.map((system) => (
                <option key={system} value={`${system}`}>
                  {system === 0 ? 'the base' : `robot ${system}`}
                </option>
              ))}
            </select>
          </label>
        )}
        <Legend />
      </div>
      <div class="graph-box" ref={box}>
        {width.value > 0 && (
          <div class="graph-ground" style={{ width: `${layout.width}px`, height: `${layout.height}px` }}>
            <svg width={layout.width} height={layout.height} aria-hidden="true">
              <Links hosts={hosts} layout={layout} links={studio.fleet.value?.links ?? []} />
              <Boxes layout={layout} />
              <Flow edges={edges} layout={layout} />
            </svg>
            {hosts.map((host) => (
              <HostTitle key={host.name} host={host} layout={layout} />
            ))}
            {components.map((component) => (
              <Node key={nodeId(component)} component={component} layout={layout} />
            ))}
          </div>
        )}
      </div>
      <FlowTable edges={edges} components={components} />
    </section>
  );
}

function robotsOf(studio: Studio): number[] {
  const systems = studio.hosts.value.flatMap(({ list }) => list?.router.system ?? []);
  return [...new Set(systems)].sort((a, b) => a - b);
}

// What the files want, beside who listens to whom now.
function useFlow(components: PlannedComponent[]): FlowEdge[] {
  const console = useConsole();
  const { studio, running } = useStudio();
  const live = components.flatMap((component) => liveOf(console, studio, component) ?? []);
  const visible = pageVisible.value;
  useEffect(() => console.fleet.watch(live.map(({ address }) => address)), [live.map(({ address }) => address).join()]);
  useEffect(() => {
    if (!visible) return;
    const load = () => void running.loadListeners(live, widthsOf(console));
    load();
    const timer = setInterval(load, period);
    return () => clearInterval(timer);
  }, [live.map(({ address }) => address).join(), visible]);
  const byName = new Map<string, string>();
  const byAddress = new Map<number, string>();
  for (const component of components) {
    const name = addressNameOf(component, studio.programOf(component));
    const address = addressOfPlanned(console, studio, component);
    if (address === undefined || name === undefined) continue;
    byName.set(nameOf(console, address), nodeId(component));
    byAddress.set(address, nodeId(component));
  }
  return flowEdges(studio.fleet.value?.edges, byName, running.listeners.value, byAddress);
}

// --- what is drawn

function Boxes({ layout }: { layout: Layout }) {
  return (
    <>
      {[...layout.hosts].map(([name, box]) => (
        <rect
          key={name}
          class="host-box"
          x={box.x + 0.5}
          y={box.y + 0.5}
          width={box.width - 1}
          height={box.height - 1}
          rx={10}
        />
      ))}
    </>
  );
}

function Flow({ edges, layout }: { edges: FlowEdge[]; layout: Layout }) {
  const chosen = option('at');
  return (
    <>
      <defs>
        {(['planned', 'live', 'extra'] as const).map((kind) => (
          <marker
            key={kind}
            id={`arrow-${kind}`}
            class={`flow-${kind}`}
            viewBox="0 0 8 8"
            refX="7"
            refY="4"
            markerUnits="userSpaceOnUse"
            markerWidth="10"
            markerHeight="10"
            orient="auto"
          >
            <path d="M0 0L8 4L0 8z" />
          </marker>
        ))}
      </defs>
      {edges.map(({ from, to, kind }) => {
        const [a, b] = [layout.nodes.get(from), layout.nodes.get(to)];
        if (a === undefined || b === undefined) return null;
        const near = chosen === from || chosen === to ? 'near' : '';
        return (
          <path
            key={`${from} ${to}`}
            class={`flow flow-${kind} ${near}`}
            d={curve(a, b)}
            marker-end={`url(#arrow-${kind})`}
          />
        );
      })}
    </>
  );
}

function Links({ hosts, layout, links }: { hosts: Host[]; layout: Layout; links: LinkBudget[] }) {
  return (
    <>
      {hosts.map(({ name, above }) => {
        const [a, b] = [layout.hosts.get(name), layout.hosts.get(above ?? '')];
        if (a === undefined || b === undefined) return null;
        const line = connection(a, b);
        const fullest = links
          .filter(({ host, link }) => (host === name && link === above) || (host === above && link === name))
          .sort((x, y) => (y.worst_share ?? 0) - (x.worst_share ?? 0) || y.worst_bytes_per_s - x.worst_bytes_per_s)[0];
        return (
          <g key={name} class={`host-link level-${fullest?.level ?? 'ok'}`}>
            <path d={line.path} />
            {fullest !== undefined && (
              <text x={line.x + 10} y={line.y + 5}>
                {linkText(fullest)}
              </text>
            )}
          </g>
        );
      })}
    </>
  );
}

function linkText({ worst_share: share, worst_bytes_per_s: worst, rate_bytes_per_s: rate, level }: LinkBudget): string {
  if (share === null || rate === null) return `${bytes(worst)}/s`;
  const warning = { ok: '', yellow: ', nearly full', red: ', too much' }[level];
  return `${percent(share)} of ${bytes(rate)}/s${warning}`;
}

function placeInTree(role: string, system: number): string {
  if (role === 'top') return 'top router';
  return role === 'system' ? `system ${system}` : `system ${system}, ${role}`;
}

function HostTitle({ host, layout }: { host: Host; layout: Layout }) {
  const { studio } = useStudio();
  const box = layout.hosts.get(host.name);
  if (box === undefined) return null;
  const id = keyOf(host.name, 'router.toml');
  const errors = studio.problems.value.filter((each) => each.host === host.name && each.file === 'router.toml').length;
  const changed = studio.changed.value.includes(id);
  const about = host.list === undefined ? host.trouble : placeInTree(host.role, host.list.router.system);
  return (
    <button
      type="button"
      class={`quiet host-title ${errors > 0 ? 'wrong' : ''}`}
      style={{ left: `${box.x + 6}px`, top: `${box.y + 3}px`, maxWidth: `${box.width - 12}px` }}
      aria-pressed={option('at') === id}
      disabled={host.list === undefined}
      onClick={() => choose(id)}
    >
      <strong>
        {host.name}
        {changed && <Mark text="changed" />}
      </strong>
      <span class="faint small">{about}</span>
    </button>
  );
}

function Node({ component, layout }: { component: PlannedComponent; layout: Layout }) {
  const console = useConsole();
  const { studio } = useStudio();
  const id = nodeId(component);
  const box = layout.nodes.get(id);
  if (box === undefined) return null;
  const state = liveOf(console, studio, component)?.state.value;
  const file = fileOf(component.key);
  const problems = studio.problems.value.filter(
    (each) => each.host === component.host && each.file === file && each.path?.startsWith(component.path),
  );
  const errors = problems.filter(({ severity }) => severity === 'error').length;
  return (
    <button
      type="button"
      class={`node ${errors > 0 ? 'wrong' : ''}`}
      style={{ left: `${box.x}px`, top: `${box.y}px`, width: `${box.width}px`, height: `${box.height}px` }}
      aria-pressed={option('at') === id}
      title={studio.programOf(component)?.purpose ?? component.command}
      onClick={() => choose(id)}
    >
      <span class="node-name">
        {state !== undefined && <Lamp state={state} />} {component.title}
      </span>
      <span class="small faint">
        {errors > 0 ? (
          <span class="bad">{errors === 1 ? '1 error' : `${errors} errors`}</span>
        ) : (
          (addressNameOf(component, studio.programOf(component)) ?? (component.on ? `on ${component.on}` : 'program'))
        )}
        {state !== undefined && <span class="hidden">, {stateWord(state)}</span>}
      </span>
    </button>
  );
}

const choose = (id: string) => show({ at: option('at') === id ? undefined : id });

function Mark({ text }: { text: string }) {
  return <span class="count">{text}</span>;
}

const legend = [
  ['live', 'stream of data'],
  ['planned', 'in the files, no stream now'],
  ['extra', 'stream that is in no file, or wanted from nobody'],
] as const;

function Legend() {
  return (
    <ul class="legend" aria-label="Lines between components">
      {legend.map(([kind, text]) => (
        <li key={kind}>
          <svg width="34" height="10" aria-hidden="true">
            <path class={`flow flow-${kind}`} d="M1 5H33" />
          </svg>{' '}
          {text}
        </li>
      ))}
    </ul>
  );
}

// The same as a table, for those who do not see the lines.
function FlowTable({ edges, components }: { edges: FlowEdge[]; components: PlannedComponent[] }) {
  const names = new Map(components.map((component) => [nodeId(component), `${component.title} on ${component.host}`]));
  const words = { live: 'stream', planned: 'do not stream now', extra: 'differ from the files' };
  return (
    <details class="flow-table">
      <summary>Who uses whose data, as a table</summary>
      <table class="list">
        <thead>
          <tr>
            <th scope="col">User</th>
            <th scope="col">uses data of</th>
            <th scope="col">by</th>
            <th scope="col">They</th>
          </tr>
        </thead>
        <tbody>
          {edges.map(({ from, to, kind, parameter, missing }) => (
            <tr key={`${from} ${to} ${parameter}`}>
              <td>{names.get(to) ?? to}</td>
              <td>{missing ? `${from}, which nobody has` : (names.get(from) ?? from)}</td>
              <td>{parameter}</td>
              <td class={kind === 'extra' ? 'bad' : ''}>{words[kind]}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </details>
  );
}
