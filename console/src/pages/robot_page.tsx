// One robot: its components on the left, the views of those that were opened beside them.

import { type Signal, useSignal } from '@preact/signals';
import type { RefObject } from 'preact';
import { useCallback, useEffect, useMemo, useRef } from 'preact/hooks';
import { nameOf, useConsole } from '../app/console';
import { isText } from '../app/keys';
import { route, setOption } from '../app/route';
import { type Component, type Robot, shortName } from '../model/fleet';
import { useAttempt } from '../ui/attempt';
import { Commands } from '../ui/commands';
import { FilterBox } from '../ui/filter_box';
import { Icon } from '../ui/icons';
import { Lamp, stateWord } from '../ui/lamp';
import { needs } from '../ui/needs';
import { Parameters } from '../ui/parameters';
import { InSight, useInSight } from '../ui/use_stream';
import { groupOf, groups } from '../views/groups';
import { viewFor } from '../views/views';

export function RobotPage() {
  const console = useConsole();
  const system = Number(route.value.arguments[0] ?? 0);
  const robot = console.fleet.robots.value.find((each) => each.system === system);
  if (robot === undefined)
    return (
      <section class="empty">
        <h1>Robot {system} is not here</h1>
        <p>None of its components has registered at this router or behind its links.</p>
        <p>
          <a href="#/fleet">All robots</a>
        </p>
      </section>
    );
  return (
    <div class="robot-page">
      <ComponentList robot={robot} />
      <Tiles robot={robot} />
    </div>
  );
}

// --- the list of components

function ComponentList({ robot }: { robot: Robot }) {
  const console = useConsole();
  const filter = useSignal('');
  useEffect(() => console.fleet.watch(robot.components.map(({ address }) => address)), [robot]);
  const shown = robot.components.filter(({ address }) =>
    nameOf(console, address).toLowerCase().includes(filter.value.toLowerCase()),
  );
  return (
    <aside aria-label="Components">
      <h1>{robot.system === 0 ? 'Base' : `Robot ${robot.system}`}</h1>
      <FilterBox label="Filter components" value={filter.value} change={(text) => (filter.value = text)} />
      {groups.map((group) => {
        const members = shown.filter(({ classId }) => groupOf(classId) === group);
        return (
          members.length > 0 && (
            <details key={group} open>
              <summary>
                <h2>{group}</h2>
              </summary>
              <ul>
                {members.map((component) => (
                  <ComponentRow key={component.address} component={component} />
                ))}
              </ul>
            </details>
          )
        );
      })}
      <AllOff robot={robot} />
    </aside>
  );
}

function ComponentRow({ component }: { component: Component }) {
  const console = useConsole();
  const { attempt, busy, Failure } = useAttempt();
  const state = component.state.value;
  const name = shortName(component);
  const isOn = state === 'on' || state === 'error';
  const open = openTiles().includes(name);
  return (
    <li class="component">
      <button
        type="button"
        class="quiet lamp-button"
        onClick={() => attempt(() => console.fleet.turn(component, !isOn))}
        aria-pressed={isOn}
        aria-label={`${name}: ${stateWord(state)}; turn ${isOn ? 'off' : 'on'}`}
        {...needs(isOn ? 'OFF' : 'ON', {
          disabled: busy.value || state === 'unknown',
          title: `${stateWord(state)}; click to turn ${isOn ? 'off' : 'on'}`,
        })}
      >
        <Lamp state={state} />
      </button>
      <button
        type="button"
        class={`quiet name ${open ? 'open' : ''}`}
        aria-pressed={open}
        onClick={() => toggleTile(name)}
      >
        {name}
        {busy.value && <span class="faint"> …</span>}
      </button>
      <Failure />
    </li>
  );
}

function AllOff({ robot }: { robot: Robot }) {
  const console = useConsole();
  const progress = useSignal('');
  const show = (text: string) => {
    progress.value = text;
  };
  const allOff = () =>
    console.fleet.turnAllOff(robot, show).then(
      () => show('All are off'),
      (error: Error) => show(error.message),
    );
  return (
    <p class="actions">
      <button type="button" {...needs('OFF')} onClick={allOff}>
        All off
      </button>
      <span role="status" class="small">
        {progress.value}
      </span>
    </p>
  );
}

// --- tiles

const listed = (text: string | undefined | null) => (text ?? '').split(',').filter((name) => name !== '');
const openTiles = () => listed(route.value.options.get('tiles'));
const memory = (system: number) => `rack.tiles.${system}`;

let opened: string | undefined; // last by hand: it is brought into sight

function toggleTile(name: string) {
  const tiles = openTiles();
  const isOpen = tiles.includes(name);
  const next = isOpen ? tiles.filter((tile) => tile !== name) : [...tiles, name];
  opened = isOpen ? undefined : name;
  setOption('tiles', next.join(','));
  localStorage.setItem(memory(Number(route.value.arguments[0])), next.join(','));
}

function Tiles({ robot }: { robot: Robot }) {
  const names = openTiles();
  const full = useSignal<string | undefined>(undefined);
  useEffect(() => {
    // Who comes without tiles finds those that were open last.
    if (!route.value.options.has('tiles')) setOption('tiles', localStorage.getItem(memory(robot.system)) ?? undefined);
  }, [robot.system]);
  useViewKeys(robot, full);
  const [box, columns] = useColumns();
  if (names.length === 0)
    return (
      <section class="empty">
        <h2>Open a component from the list</h2>
        <p>
          Its lamp turns it on and off; its name opens its view here. The address of this page holds the views: send it,
          or keep it as a bookmark.
        </p>
        <p class="actions">
          <a class="button" href={`#/map?robots=${robot.system}`}>
            Map
          </a>
          <a class="button" href={`#/drive/${robot.system}`}>
            Drive
          </a>
        </p>
      </section>
    );
  return (
    <div ref={box} class={`tiles ${full.value !== undefined && names.includes(full.value) ? 'one' : ''}`}>
      {names.map((name, i) => {
        const column = (i % columns) + 1;
        const component = robot.components.find((each) => shortName(each) === name);
        return component === undefined ? (
          <MissingTile key={name} name={name} column={column} />
        ) : (
          <Tile key={name} name={name} column={column} component={component} full={full} />
        );
      })}
    </div>
  );
}

// Tiles are stacked in columns without gaps: each is in the next column, and spans as many of the low rows of the grid as it
// is high. So one that grows moves only those below it.
const columnWidth = 22 * 16; // pixels
const rowHeight = 4; // pixels, as in the style sheet

function useColumns(): [(element: HTMLElement | null) => void, number] {
  const columns = useSignal(1);
  const observer = useMemo(
    () =>
      new ResizeObserver(([entry]) => {
        if (entry !== undefined) columns.value = Math.max(1, Math.floor(entry.contentRect.width / columnWidth));
      }),
    [],
  );
  const observe = useCallback((element: HTMLElement | null) => {
    if (element === null) observer.disconnect();
    else observer.observe(element);
  }, []);
  return [observe, columns.value];
}

function useSpan(element: RefObject<HTMLElement | null>) {
  useEffect(() => {
    const tile = element.current;
    if (tile === null) return;
    const observer = new ResizeObserver(() => {
      tile.style.gridRowEnd = `span ${Math.ceil((tile.offsetHeight + tileGap) / rowHeight)}`;
    });
    observer.observe(tile);
    return () => observer.disconnect();
  }, []);
}

const tileGap = 12; // pixels

// F1 to F8 open the first views of the list, f gives the whole page to the one that has the focus, or to the first.
function useViewKeys(robot: Robot, full: Signal<string | undefined>) {
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      if (event.ctrlKey || event.altKey || event.metaKey || isText(event.target)) return;
      const [, number] = /^F([1-8])$/.exec(event.key) ?? [];
      const component = number === undefined ? undefined : robot.components[Number(number) - 1];
      if (component !== undefined) {
        event.preventDefault();
        toggleTile(shortName(component));
      } else if (event.key === 'f') {
        const focused = document.activeElement?.closest('.tile')?.getAttribute('aria-label');
        full.value = full.value === undefined ? (focused ?? openTiles()[0]) : undefined;
      }
    };
    addEventListener('keydown', onKey);
    return () => removeEventListener('keydown', onKey);
  }, [robot]);
}

type Tab = 'view' | 'parameters' | 'commands';

interface TileProperties {
  name: string;
  column: number;
  component: Component;
  full: Signal<string | undefined>;
}

function Tile({ name, column, component, full }: TileProperties) {
  const tab = useSignal<Tab>('view');
  const [element, inSight] = useInSight<HTMLElement>();
  useSpan(element);
  useEffect(() => {
    if (opened === name) element.current?.scrollIntoView({ block: 'nearest' });
    opened = undefined;
  }, []);
  const isFull = full.value === name;
  const View = viewFor(component.classId);
  const choose = (value: Tab) => () => {
    tab.value = value;
  };
  return (
    <section
      ref={element}
      class={`tile ${isFull ? 'full' : ''}`}
      aria-label={name}
      style={isFull ? {} : { gridColumnStart: column }}
    >
      <header>
        <Lamp state={component.state.value} />
        <h2>{name}</h2>
        <span class="small faint">{stateWord(component.state.value)}</span>
        <span class="grow" />
        <button
          type="button"
          class="quiet"
          aria-pressed={isFull}
          aria-label={`Only ${name}`}
          title="The whole page (f)"
          onClick={() => {
            full.value = isFull ? undefined : name;
          }}
        >
          <Icon name="full" />
        </button>
        <button type="button" class="quiet" aria-label={`Close ${name}`} onClick={() => toggleTile(name)}>
          <Icon name="close" />
        </button>
      </header>
      <div class="tile-tabs">
        <button type="button" class="quiet" aria-pressed={tab.value === 'view'} onClick={choose('view')}>
          Data
        </button>
        <button type="button" class="quiet" aria-pressed={tab.value === 'parameters'} onClick={choose('parameters')}>
          Parameters
        </button>
        <button type="button" class="quiet" aria-pressed={tab.value === 'commands'} onClick={choose('commands')}>
          Commands
        </button>
      </div>
      <InSight.Provider value={inSight}>
        <div class="tile-body">
          {tab.value === 'view' && <View component={component} />}
          {tab.value === 'parameters' && <Parameters component={component} />}
          {tab.value === 'commands' && <Commands component={component} />}
        </div>
      </InSight.Provider>
    </section>
  );
}

function MissingTile({ name, column }: { name: string; column: number }) {
  const element = useRef<HTMLElement>(null);
  useSpan(element);
  return (
    <section ref={element} class="tile" aria-label={name} style={{ gridColumnStart: column }}>
      <header>
        <Lamp state="silent" />
        <h2>{name}</h2>
        <span class="grow" />
        <button type="button" class="quiet" aria-label={`Close ${name}`} onClick={() => toggleTile(name)}>
          <Icon name="close" />
        </button>
      </header>
      <p class="tile-body faint">It is not registered at present.</p>
    </section>
  );
}
