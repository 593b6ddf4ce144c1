// One robot: its components on the left, the views of those that were opened beside them.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { nameOf, useConsole } from '../app/console';
import { route } from '../app/route';
import { type Component, type Robot, shortName } from '../model/fleet';
import { type LogText, lastOf } from '../model/log';
import { useAttempt } from '../ui/attempt';
import { FilterBox } from '../ui/filter_box';
import { Lamp, stateWord } from '../ui/lamp';
import { needs } from '../ui/needs';
import { timeText } from '../ui/times';
import { groupOf, groups } from '../views/groups';
import { openTiles, toggleTile } from './open_tiles';
import { Tiles } from './robot_tiles';

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
      <div class="robot-views">
        <Tiles robot={robot} />
        <Strip robot={robot} />
      </div>
    </div>
  );
}

const stripRows = 3;

// Its newest errors and warnings.
function Strip({ robot }: { robot: Robot }) {
  const console = useConsole();
  const all = console.log.texts.value;
  const own = new Set(robot.components.map(({ address }) => address));
  const isTrouble = ({ sender, level }: LogText) => own.has(sender) && (level === 'error' || level === 'warning');
  const texts = lastOf(all, isTrouble, stripRows);
  if (texts.length === 0) return null;
  return (
    <section class="strip" aria-label="Newest errors and warnings">
      <ul>
        {texts.map(({ number, time, level, sender, text, count }) => (
          <li key={number} class={`level-${level}`} title={text}>
            <span class="time">{timeText(time)}</span> {level}: {nameOf(console, sender)}: {text}
            {count > 1 && <span class="count">{count} times</span>}
          </li>
        ))}
      </ul>
      <a href={`#/messages?filter=${encodeURIComponent(`(${robot.system}/`)}`}>All of them</a>
    </section>
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
  const open = openTiles().some((tile) => tile.name === name);
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
