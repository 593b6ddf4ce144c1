// All robots, the worst first: which is in trouble, and why.

import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { nameOf, useConsole } from '../app/console';
import { go, route, setOption } from '../app/route';
import { classId, className } from '../codec/catalogue';
import type { ChassisData } from '../codec/messages';
import type { Component, Robot } from '../model/fleet';
import type { Lease } from '../model/leases';
import type { LogText } from '../model/log';
import { stopRobots } from '../model/stop';
import { useAdminList } from '../network/admin_list';
import { explainedTroubles, type LinkTrouble, worst } from '../network/link_health';
import type { LinkItem, RouterItem } from '../network/reports';
import { useAttempt } from '../ui/attempt';
import { useNow } from '../ui/connection';
import { FilterBox } from '../ui/filter_box';
import { Icon } from '../ui/icons';
import { Lamp } from '../ui/lamp';
import { needs } from '../ui/needs';
import { age, duration } from '../ui/quantities';
import { InSight, useInSight, useStream } from '../ui/use_stream';
import { matchesRobot } from './fleet_filter';

interface Row {
  robot: Robot;
  on: number;
  off: number;
  bad: Component[]; // in error, or without an answer
  line: LinkTrouble[]; // of the link to its router
}

const rowsAtOnce = 60; // more than a large screen shows
const errorAge = 5 * 60 * 1000; // ms
const noteTime = 5000; // ms
const goneTime = 20_000; // ms; longer than between two notes of when it was seen
const linksMax = 200; // 300 kB and 2 ms of the router a question; larger fleets: see the page of the network

export function FleetPage() {
  const console = useConsole();
  const filter = route.value.options.get('filter') ?? '';
  const order = route.value.options.get('sort') ?? 'trouble';
  const robots = console.fleet.robots.value;
  const routers = useRouters();
  const lines = useLines(routers.length);
  const names = new Map(routers.map(({ system, name }) => [system, name]));
  const isWanted = (system: number, ...words: string[]) =>
    matchesRobot({ system, name: names.get(system), words }, filter);
  const allAway = routers.filter(({ kind, state }) => kind !== 'self' && state !== 'up');
  const lost = new Set(allAway.map(({ system }) => system));
  const rows = sorted(
    robots
      .map((robot) => rowOf(robot, lines.get(robot.system) ?? []))
      .filter((row) => isWanted(row.robot.system, wordOf(row)[0], lost.has(row.robot.system) ? 'away' : '')),
    order,
  );
  const allGone = useGone(robots, allAway);
  const away = allAway.filter(({ system }) => isWanted(system, 'away'));
  const gone = allGone.filter(({ system }) => isWanted(system, 'gone'));
  // Those that are missing come first.
  const shown = useSignal(rowsAtOnce);
  const count = away.length + gone.length + rows.length;
  const visibleAway = away.slice(0, shown.value);
  const visibleGone = gone.slice(0, Math.max(0, shown.value - away.length));
  const visible = rows.slice(0, Math.max(0, shown.value - away.length - gone.length));
  useWatched(visible.flatMap(({ robot }) => robot.components.map(({ address }) => address)));
  const drivers = useDrivers(visible.map(({ robot }) => robot.system));
  if (robots.length === 0 && allAway.length === 0 && allGone.length === 0) return <NoRobots />;
  return (
    <section>
      <div class="tools">
        <h1>Fleet</h1>
        <Summary rows={rows} away={away} gone={gone.length} />
        <span class="grow" />
        <FilterBox
          label="Filter robots"
          placeholder="Number, name or state"
          value={filter}
          change={(text) => setOption('filter', text)}
        />
        <label>
          Sort by{' '}
          <select value={order} onChange={(event) => setOption('sort', event.currentTarget.value)}>
            <option value="trouble">trouble</option>
            <option value="number">number</option>
          </select>
        </label>
      </div>
      <ul class="robots">
        {visibleAway.map((router) => (
          <Away key={router.address.raw} router={router} present={robots} />
        ))}
        {visibleGone.map((each) => (
          <Gone key={each.system} robot={each} />
        ))}
        {visible.map((row) => (
          <RobotCard
            key={row.robot.system}
            row={row}
            router={routers.find(({ system }) => system === row.robot.system)}
            driver={drivers.get(row.robot.system)}
          />
        ))}
      </ul>
      {count > shown.value && (
        <button type="button" onClick={() => (shown.value += rowsAtOnce)}>
          Show {Math.min(rowsAtOnce, count - shown.value)} more of {count}
        </button>
      )}
    </section>
  );
}

function useWatched(addresses: number[]) {
  const { fleet } = useConsole();
  useEffect(() => fleet.watch(addresses), [addresses.join()]);
}

// Who drives which of these robots.
function useDrivers(robots: number[]): ReadonlyMap<number, Lease> {
  const { leases } = useConsole();
  const shown = useRef(robots);
  shown.current = robots; // they change often; who drives is asked at a period
  const { items } = useAdminList(async () => [...(await leases.holders(shown.current)).values()], 'drivers', 3000);
  return new Map((items ?? []).map((lease) => [lease.robot, lease]));
}

function NoRobots() {
  const { client } = useConsole();
  const connected = client.connection.value.state === 'connected';
  return (
    <section class="empty">
      <h1>{connected ? 'No robot is here yet' : 'Waiting for the router'}</h1>
      {connected && (
        <p>
          No component has registered at this router or behind its links. Start one, for example
          <br />
          <code>timsctl up deploy/robots/emulated.toml</code>
        </p>
      )}
    </section>
  );
}

// The routers that the own one knows: those of the robots, also of robots that are away.
function useRouters(): RouterItem[] {
  const { admin } = useConsole();
  return useAdminList(() => admin.all<RouterItem>({ ask: 'routers' }), 'routers', 3000).items ?? [];
}

// What is wrong with the links to robots that are here. One that is not up is said by its router, which is away.
function useLines(routers: number): ReadonlyMap<number, LinkTrouble[]> {
  const { admin } = useConsole();
  const isAsked = routers > 1 && routers <= linksMax;
  const { items = [] } = useAdminList<LinkItem>(
    async () => (isAsked ? admin.all<LinkItem>({ ask: 'links' }) : []),
    `links ${isAsked}`,
    3000,
  );
  return new Map(
    items
      .filter(({ kind, state }) => kind === 'sub' && state === 'up')
      .map((link) => [link.system, explainedTroubles(link)]),
  );
}

interface GoneRobot {
  system: number;
  seenAt: number; // Date.now()
}

// Robots that were here, of which nothing is left, not even a router that is known to be away.
function useGone(robots: Robot[], away: RouterItem[]): GoneRobot[] {
  const { client, fleet, seen } = useConsole();
  const { state, router } = client.connection.value;
  const isListed = fleet.listed.value && state === 'connected';
  const here = robots.map(({ system }) => system).filter((system) => system !== 0);
  const now = useNow(noteTime);
  useEffect(() => {
    // The list of robots is that of before the connection was lost.
    if (isListed && router !== undefined) seen.note(router.name, here, Date.now());
  }, [isListed, router, here.join(), now]);
  if (!fleet.listed.value) return [];
  const known = new Set([...here, ...away.map(({ system }) => system)]);
  return [...seen.times.value]
    .filter(([system, time]) => !known.has(system) && time < Date.now() - goneTime)
    .map(([system, seenAt]) => ({ system, seenAt }));
}

interface SummaryProperties {
  rows: Row[];
  away: RouterItem[];
  gone: number;
}

function Summary({ rows, away, gone }: SummaryProperties) {
  const present = new Set(rows.map(({ robot }) => robot.system));
  const missing = gone + away.filter(({ system }) => !present.has(system)).length;
  const lost = new Set(away.map(({ system }) => system));
  const troubled = missing + rows.filter((row) => isTroubled(row) || lost.has(row.robot.system)).length;
  const count = rows.length + missing;
  return (
    <p class="summary" aria-live="polite">
      {count === 1 ? '1 robot' : `${count} robots`}
      {troubled > 0 ? <strong class="bad">, {troubled} in trouble</strong> : ', none in trouble'}
    </p>
  );
}

const isTroubled = ({ bad, line }: Row) => bad.length > 0 || line.length > 0;

// What one sees first: a word for the whole robot.
function wordOf({ robot, on, bad, line }: Row): [word: string, kind: string] {
  if (bad.some(({ state }) => state.value === 'error')) return ['error', 'bad'];
  if (bad.length > 0) return ['no answer', 'bad'];
  if (line.length > 0) return ['bad link', worst(line)];
  if (robot.components.every(({ state }) => state.value === 'unknown')) return ['asking', 'faint'];
  return on > 0 ? ['works', 'good'] : ['off', 'faint'];
}

interface CardProperties {
  row: Row;
  router: RouterItem | undefined;
  driver: Lease | undefined;
}

function RobotCard({ row, router, driver }: CardProperties) {
  const { robot, on, off, bad, line } = row;
  const [word, kind] = wordOf(row);
  const console = useConsole();
  const { attempt, busy, Failure } = useAttempt();
  const [element, inSight] = useInSight<HTMLLIElement>();
  return (
    <li ref={element} class={`robot ${kind === 'bad' ? 'troubled' : kind === 'warn' ? 'doubtful' : ''}`}>
      <h2>
        <a href={`#/robot/${robot.system}`}>{robot.system === 0 ? 'Base' : `Robot ${robot.system}`}</a>
        <span class={`word ${kind}`}>{word}</span>
      </h2>
      <p class="counts">
        <span>
          <Lamp state="on" /> {on} on
        </span>
        <span>
          <Lamp state="off" /> {off} off
        </span>
        <span class="faint">
          {robot.components.length} components{router?.rtt_s != null && `, link ${duration(router.rtt_s)}`}
        </span>
        <InSight.Provider value={inSight}>
          <Battery robot={robot} />
        </InSight.Provider>
      </p>
      {driver !== undefined && <p class="small">{driver.holder} drives it</p>}
      <ul class="troubles">
        {line.length > 0 && (
          <li class={worst(line)}>
            <Icon name="warning" /> <a href="#/network?tab=links">Its link</a>
            {line.map(({ text }) => (
              <p key={text} class="small">
                {text}
              </p>
            ))}
          </li>
        )}
        {bad.map((component) => (
          <li key={component.address} class={component.state.value === 'error' ? 'bad' : 'warn'}>
            <Lamp state={component.state.value} />{' '}
            <a href={`#/robot/${robot.system}?tiles=${tileOf(component)}`}>{nameOf(console, component.address)}</a>{' '}
            {component.state.value === 'error' ? 'is in error' : 'does not answer'}
            <Reason component={component} />
          </li>
        ))}
      </ul>
      {bad.length === 0 && <LastError robot={robot} />}
      <p class="actions">
        <button
          type="button"
          onClick={() =>
            go({ page: 'map', arguments: [], options: new URLSearchParams({ robots: `${robot.system}` }) })
          }
        >
          Map
        </button>
        <a class="button" href={`#/drive/${robot.system}`}>
          Drive
        </a>
        <span class="grow" />
        <button
          type="button"
          {...needs('Chassis.SET_ACTIVE_PILOT')}
          onClick={() => attempt(() => stopRobots(console.client, console.fleet, [robot.system]))}
        >
          Stop
        </button>
        <button
          type="button"
          {...needs('OFF', { disabled: busy.value })}
          onClick={() => attempt(() => console.fleet.turnAllOff(robot))}
        >
          All off
        </button>
      </p>
      <Failure />
    </li>
  );
}

const batteryPeriod = 5000; // ms

// Of a chassis that is on and measures it.
function Battery({ robot }: { robot: Robot }) {
  const chassis = robot.components.find((each) => each.classId === classId('Chassis') && each.state.value === 'on');
  const { value } = useStream<ChassisData>(chassis?.address, batteryPeriod);
  const voltage = value.value?.data.battery ?? 0;
  return voltage > 0 ? <span>battery {voltage.toFixed(1)} V</span> : null;
}

// A router that the own one has known and no longer reaches: its robot is away as a whole.
function Away({ router, present }: { router: RouterItem; present: Robot[] }) {
  return (
    <li class="robot troubled">
      <h2>
        {present.some(({ system }) => system === router.system) ? router.name : `Robot ${router.system}`}
        <span class="word bad">away</span>
      </h2>
      <p class="bad grow">
        <Icon name="warning" /> Its router {router.name ?? router.address.name} is not reachable since{' '}
        {age(router.since_s)}
      </p>
      <p class="actions">
        <a class="button" href={`#/network?tab=explain&to=${encodeURIComponent(router.address.name)}`}>
          Why?
        </a>
      </p>
    </li>
  );
}

function Gone({ robot: { system, seenAt } }: { robot: GoneRobot }) {
  const { seen } = useConsole();
  return (
    <li class="robot troubled">
      <h2>
        Robot {system}
        <span class="word bad">gone</span>
      </h2>
      <p class="bad grow">
        <Icon name="warning" /> None of its components is registered since {age((Date.now() - seenAt) / 1000)}
      </p>
      <p class="actions">
        <a class="button" href={`#/network?tab=explain&to=${encodeURIComponent(`Chassis(${system}/0)`)}`}>
          Why?
        </a>
        <span class="grow" />
        <button type="button" title="It is shown again when it comes back" onClick={() => seen.forget(system)}>
          Forget
        </button>
      </p>
    </li>
  );
}

// Why a component is in trouble, as it says itself, or by its newest error or warning. If none is known: where to look.
function Reason({ component }: { component: Component }) {
  const console = useConsole();
  const { log } = console;
  const isSilent = component.state.value !== 'error';
  const last = log.newestOf(component.address, 'error') ?? log.newestOf(component.address, 'warning');
  const messages = `#/messages?filter=${encodeURIComponent(nameOf(console, component.address))}`;
  const why = component.why.value;
  if (why !== '')
    return (
      <p class="small last-error" title={why}>
        {why} (<a href={messages}>messages</a>)
      </p>
    );
  if (last === undefined)
    return (
      <p class="small faint">
        {isSilent ? 'Its program may have ended' : noReason}:{' '}
        <a href={isSilent ? '#/studio' : messages}>{isSilent ? 'what runs on its host' : 'its messages'}</a>
      </p>
    );
  return (
    <p class="small last-error" title={last.text}>
      <a href={messages}>{age((Date.now() - last.time.getTime()) / 1000)} ago</a>: {last.text}
    </p>
  );
}

// A program of the original, at a host without a log.
const noReason = 'It gives no reason, and none was logged since this page was opened';

// The newest error of a robot of which no component is in trouble now.
function LastError({ robot }: { robot: Robot }) {
  const console = useConsole();
  const errors = robot.components.flatMap(({ address }) => console.log.newestOf(address, 'error') ?? []);
  const last = errors.reduce<LogText | undefined>((a, b) => (a !== undefined && a.time > b.time ? a : b), undefined);
  if (last === undefined || Date.now() - last.time.getTime() > errorAge) return null;
  return (
    <p class="small bad last-error" title={last.text}>
      <a href={`#/messages?filter=${encodeURIComponent(nameOf(console, last.sender))}`}>
        {nameOf(console, last.sender)}
      </a>
      : {last.text}
    </p>
  );
}

const tileOf = ({ classId, instance }: Component) => `${className(classId) ?? classId}/${instance}`;

function rowOf(robot: Robot, line: LinkTrouble[]): Row {
  const row: Row = { robot, on: 0, off: 0, bad: [], line };
  for (const component of robot.components) {
    const state = component.state.value;
    if (state === 'on') ++row.on;
    else if (state === 'off') ++row.off;
    else if (state !== 'unknown') row.bad.push(component);
  }
  return row;
}

function sorted(rows: Row[], order: string): Row[] {
  if (order === 'number') return rows;
  return rows.sort(
    (a, b) => b.bad.length - a.bad.length || b.line.length - a.line.length || a.robot.system - b.robot.system,
  );
}
