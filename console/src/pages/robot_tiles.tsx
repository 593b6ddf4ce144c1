// The views of a robot's components as tiles: beside the list, in columns.

import { type Signal, useSignal } from '@preact/signals';
import type { RefObject } from 'preact';
import { useCallback, useEffect, useMemo, useRef } from 'preact/hooks';
import { nameOf, useConsole } from '../app/console';
import { isText } from '../app/focus';
import { route } from '../app/route';
import { findMessage } from '../codec/catalogue';
import { type Component, type Robot, shortName } from '../model/fleet';
import { numberFields } from '../plots/number_fields';
import { types } from '../tims/header';
import { Boundary } from '../ui/boundary';
import { Commands } from '../ui/commands';
import { Icon } from '../ui/icons';
import { Lamp, stateWord } from '../ui/lamp';
import { Parameters } from '../ui/parameters';
import { InSight, useInSight } from '../ui/use_stream';
import { viewFor } from '../views/views';
import {
  isWide,
  moveTile,
  moveTileTo,
  openTiles,
  recallTiles,
  setTiles,
  toggleTile,
  toggleWide,
  wasOpenedNow,
} from './open_tiles';
import { kitsOf, placesOf } from './tiles';

export function Tiles({ robot }: { robot: Robot }) {
  const open = openTiles();
  const full = useSignal<string | undefined>(undefined);
  useEffect(() => {
    // Who comes without tiles finds those that were open last.
    if (!route.value.options.has('tiles')) recallTiles(robot.system);
  }, [robot.system]);
  useViewKeys(robot, full);
  const [box, columns] = useColumns();
  const kits = kitsOf(robot.components.map(shortName));
  if (open.length === 0)
    return (
      <section class="empty">
        <h2>Open a component from the list</h2>
        <p>
          Its lamp turns it on and off; its name opens its view here. The address of this page holds the views: send it,
          or keep it as a bookmark.
        </p>
        <p class="actions">
          {kits.length > 0 && 'Or open what belongs together:'}
          {kits.map(({ name, tiles }) => (
            <button
              key={name}
              type="button"
              title={tiles.map((tile) => tile.name).join(', ')}
              onClick={() => setTiles(tiles)}
            >
              {name}
            </button>
          ))}
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
  const places = placesOf(open, columns);
  const isOne = open.some(({ name }) => name === full.value);
  return (
    <div ref={box} class={`tiles ${isOne ? 'one' : ''}`}>
      {open.map(({ name }, i) => {
        const component = robot.components.find((each) => shortName(each) === name);
        const place = places[i] ?? '';
        return component === undefined ? (
          <MissingTile key={name} name={name} place={place} />
        ) : (
          <Tile key={name} name={name} place={place} component={component} full={full} />
        );
      })}
    </div>
  );
}

const tileGap = 12; // pixels, as in the style sheet

// Tiles are stacked in columns without gaps: each spans as many of the low rows of the grid as it
// is high. So one that grows moves only those below it.
const columnWidth = 22 * 16 + tileGap; // pixels
const rowHeight = 4; // pixels, as in the style sheet

function useColumns(): [(element: HTMLElement | null) => void, number] {
  const columns = useSignal(1);
  const observer = useMemo(
    () =>
      new ResizeObserver(([entry]) => {
        if (entry !== undefined)
          columns.value = Math.max(1, Math.floor((entry.contentRect.width + tileGap) / columnWidth));
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
        full.value = full.value === undefined ? (focused ?? openTiles()[0]?.name) : undefined;
      }
    };
    addEventListener('keydown', onKey);
    return () => removeEventListener('keydown', onKey);
  }, [robot]);
}

type Tab = 'view' | 'parameters' | 'commands';

interface TileProperties {
  name: string;
  place: string; // its columns in the grid
  component: Component;
  full: Signal<string | undefined>;
}

function Tile({ name, place, component, full }: TileProperties) {
  const tab = useSignal<Tab>('view');
  const [element, inSight] = useInSight<HTMLElement>();
  useSpan(element);
  useEffect(() => {
    if (wasOpenedNow(name)) element.current?.scrollIntoView({ block: 'nearest' });
  }, []);
  const console = useConsole();
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
      style={isFull ? {} : { gridColumn: place }}
    >
      <header>
        <Lamp state={component.state.value} />
        <h2>{name}</h2>
        <span class="small faint">{stateWord(component.state.value)}</span>
        <span class="grow" />
        <MoveButton name={name} />
        <button
          type="button"
          class="quiet for-columns"
          aria-pressed={isWide(name)}
          aria-label={`Wide ${name}`}
          title="Two columns wide"
          onClick={() => toggleWide(name)}
        >
          <Icon name="wide" />
        </button>
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
        {hasNumbers(component) && (
          <a
            class="plot-link"
            aria-label={`Plot ${name}`}
            href={`#/plots?of=${encodeURIComponent(nameOf(console, component.address))}`}
          >
            Plot
          </a>
        )}
      </div>
      <InSight.Provider value={inSight}>
        <div class="tile-body">
          <Boundary key={tab.value} what="view">
            {tab.value === 'view' && <View component={component} />}
            {tab.value === 'parameters' && <Parameters component={component} />}
            {tab.value === 'commands' && <Commands component={component} />}
          </Boundary>
        </div>
      </InSight.Provider>
    </section>
  );
}

// There is something to plot.
const hasNumbers = ({ classId }: Component) =>
  numberFields(findMessage(classId, types.data)?.body?.fields ?? []).length > 0;

// Takes a tile to another place: dragged to the tile that is there, or by the arrow keys.
function MoveButton({ name }: { name: string }) {
  const target = useRef<Element | undefined>(undefined);
  const aim = (tile: Element | undefined) => {
    target.current?.classList.remove('aimed');
    tile?.classList.add('aimed');
    target.current = tile;
  };
  const drag = ({ clientX, clientY, currentTarget, pointerId }: PointerEvent & { currentTarget: Element }) => {
    if (!currentTarget.hasPointerCapture(pointerId)) return;
    const tile = document.elementFromPoint(clientX, clientY)?.closest('.tile');
    aim(tile?.contains(currentTarget) ? undefined : (tile ?? undefined));
  };
  const drop = () => {
    const other = target.current?.getAttribute('aria-label');
    aim(undefined);
    if (other) moveTileTo(name, other);
  };
  return (
    <button
      type="button"
      class="quiet move"
      aria-label={`Move ${name}`}
      title="Drag it to another tile, or use the arrow keys"
      onPointerDown={({ currentTarget, pointerId }) => currentTarget.setPointerCapture(pointerId)}
      onPointerMove={drag}
      onPointerUp={drop}
      onPointerCancel={() => aim(undefined)}
      onKeyDown={(event) => {
        const step = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 }[event.key];
        if (step === undefined) return;
        event.preventDefault();
        moveTile(name, step);
        event.currentTarget.focus(); // it is another place of the page now
      }}
    >
      <Icon name="move" />
    </button>
  );
}

function MissingTile({ name, place }: { name: string; place: string }) {
  const element = useRef<HTMLElement>(null);
  useSpan(element);
  return (
    <section ref={element} class="tile" aria-label={name} style={{ gridColumn: place }}>
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
