// Where the next goal of a robot is: a compass with an arrow to it, and the list of goals.

import { useSignal } from '@preact/signals';
import { useConsole } from '../app/console';
import { decodeStruct } from '../codec/catalogue';
import type { Position3d } from '../codec/messages';
import { type Goals, readUtmPlaces } from '../map/goals';
import type { Point } from '../map/transform';
import { command } from '../model/commands';
import type { Component } from '../model/fleet';
import { useAttempt } from '../ui/attempt';
import { degrees, metres } from '../ui/quantities';
import { NumberInput, numberOf, Values } from './parts';

interface Properties {
  position: Component;
  pose: Position3d | undefined;
}

export function GoalView({ position, pose }: Properties) {
  const { client, goals: lists } = useConsole();
  const goals = lists.of(position.system);
  const [north, east] = [useSignal('0'), useSignal('0')];
  const { attempt, Failure } = useAttempt();
  const setOne = async () =>
    goals.set([{ x: Math.round(1000 * numberOf('North', north)), y: Math.round(1000 * numberOf('East', east)) }]);
  // Where a place is in the frame of the robot, its Position knows.
  const read = async (file: File | undefined) => {
    if (file === undefined) return;
    const found: Point[] = [];
    for (const place of readUtmPlaces(await file.text())) {
      const answer = await command(client, position, 'Position.UTM_TO_POS', { ...place, altitude: 0, heading: 0 });
      found.push(decodeStruct('PositionData', answer.body, answer.flags).pos);
    }
    goals.set(found);
  };
  const count = goals.list.value.length;
  return (
    <details>
      <summary>Goals</summary>
      {pose !== undefined && <Compass goals={goals} pose={pose} />}
      <p class="actions">
        <button type="button" disabled={goals.index.value === 0} onClick={() => goals.step(-1)}>
          Previous
        </button>
        <button type="button" disabled={goals.index.value + 1 >= count} onClick={() => goals.step(1)}>
          Next
        </button>
        <button type="button" disabled={count === 0} onClick={() => goals.set([])}>
          Clear
        </button>
        <label>
          Next by itself within{' '}
          <input
            inputMode="decimal"
            size={4}
            aria-label="Next goal by itself within, in m"
            defaultValue={`${goals.turnover.value / 1000}`}
            onChange={(event) => (goals.turnover.value = Math.max(0, 1000 * Number(event.currentTarget.value) || 0))}
          />{' '}
          m
        </label>
      </p>
      <p class="actions">
        <NumberInput label="North" unit="m" value={north} />
        <NumberInput label="East" unit="m" value={east} />
        <button type="button" onClick={() => attempt(setOne)}>
          Set goal
        </button>
      </p>
      <label>
        Goals of a file, one a line: <code>32U 550000.00m E 5800000.00m N</code>{' '}
        <input
          type="file"
          accept=".txt,text/plain"
          aria-label="File of goals"
          onChange={({ currentTarget }) => attempt(() => read(currentTarget.files?.[0]))}
        />
      </label>
      <Failure />
    </details>
  );
}

// Up is where the robot looks.
function Compass({ goals, pose }: { goals: Goals; pose: Position3d }) {
  const way = goals.from(pose);
  if (way === undefined) return <p class="faint">No goal is set.</p>;
  const turn = (direction: number) => `rotate(${((direction - pose.rho) * 180) / Math.PI})`;
  const toTurn = Math.atan2(Math.sin(way.direction - pose.rho), Math.cos(way.direction - pose.rho));
  return (
    <div class="gyro">
      <svg
        class="horizon"
        viewBox="-50 -50 100 100"
        role="img"
        aria-label={`the goal is ${metres(way.distance)} away, ${degrees(toTurn)} from ahead`}
      >
        <circle class="dial" r="46" />
        <g transform={turn(0)}>
          <path class="north" d="M0 -46L4 -38H-4z" />
          <text y="-27">N</text>
        </g>
        <path class="needle" transform={turn(way.direction)} d="M0 -30L10 18L0 10L-10 18z" />
      </svg>
      <Values
        of={{
          'to the goal': metres(way.distance),
          'to the last one': metres(way.inAll),
          goal: `${goals.index.value + 1} of ${goals.list.value.length}`,
          'from ahead': degrees(toTurn),
        }}
      />
    </div>
  );
}
