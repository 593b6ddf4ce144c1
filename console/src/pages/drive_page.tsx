// Driving a robot by hand: keys, mouse, touch or gamepad. It moves only while something is held.

import { type Signal, useSignal } from '@preact/signals';
import { useEffect, useMemo, useRef } from 'preact/hooks';
import { nameOf, useConsole } from '../app/console';
import { isText } from '../app/focus';
import { route } from '../app/route';
import {
  askPilots,
  beginDriving,
  endDriving,
  type Pilots,
  pilotsOf,
  type StickPilot,
  startPilot,
} from '../drive/drive';
import { Driver } from '../drive/driver';
import { Stick } from '../drive/stick_view';
import { firstOf } from '../map/follow';
import { fittingName } from '../model/console_name';
import type { Component, Robot } from '../model/fleet';
import type { Lease } from '../model/leases';
import { Lamp, stateWord } from '../ui/lamp';
import { Hindrance } from '../ui/login';
import { needs } from '../ui/needs';
import { age } from '../ui/quantities';
import { CameraSight } from '../views/camera_view';
import { ChassisSpeed } from '../views/chassis_view';
import { HoldButton } from '../views/parts';
import { ScanSight } from '../views/scan_view';

const holderPeriod = 1000;
const askAgainTime = 1000;
const takeOverTime = 1000;

export function DrivePage() {
  const console = useConsole();
  const robots = console.fleet.robots.value.filter((robot) => firstOf(robot, 'Chassis') !== undefined);
  const system = route.value.arguments[0];
  const robot = robots.find((each) => `${each.system}` === system);
  if (robot !== undefined) return <DriveRobot key={robot.system} robot={robot} />;
  return (
    <section class="empty">
      <h1>{system === undefined ? 'Which robot?' : `Robot ${system} is not here, or has no chassis`}</h1>
      <p class="actions">
        {robots.map((each) => (
          <a key={each.system} class="button" href={`#/drive/${each.system}`}>
            Robot {each.system}
          </a>
        ))}
      </p>
      {robots.length === 0 && <p class="faint">No robot with a chassis has registered.</p>}
    </section>
  );
}

function DriveRobot({ robot }: { robot: Robot }) {
  const console = useConsole();
  const trouble = useSignal('');
  const driver = useDriver(robot, (why) => {
    trouble.value = `You no longer drive: ${why}.`;
  });
  const driven = driver.driven.value;
  const report = useSignal('');
  const busy = useSignal(false);
  const speed = useSignal(30);
  const signature = robot.components.map(({ address }) => address).join();
  const pilots = usePilots(robot, signature);
  useEffect(() => console.fleet.watch(robot.components.map(({ address }) => address)), [signature]);
  // The stick is lost with the connection; whoever comes back takes it anew.
  const stick = console.client.stick.value;
  if (driven !== undefined && stick === undefined && !busy.value) {
    driver.lose();
    trouble.value = 'The stick is released: the connection was lost.';
  }
  const attempt = async (action: () => Promise<void>) => {
    busy.value = true;
    trouble.value = '';
    report.value = '';
    try {
      await action();
    } catch (error) {
      trouble.value = (error as Error).message;
    }
    busy.value = false;
  };
  const begin = (pilot: StickPilot, over: boolean) => attempt(() => driver.begin(pilot, over));
  const end = () => attempt(() => driver.end());
  // A pilot that drives by itself.
  const start = (pilot: Component) =>
    attempt(async () => {
      await driver.end();
      await startPilot(console, robot, pilot);
      report.value = `${nameOf(console, pilot.address)} drives.`;
    });
  const all = pilotsOf(robot);
  const keyOf = (pilot: Component) => `${all.indexOf(pilot) + 1}`;
  const other = useHolder(robot, driven === undefined);
  // A digit chooses a pilot, as in the original.
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      if (isText(event.target) || event.ctrlKey || event.altKey || event.metaKey || busy.peek()) return;
      const chosen = /^Digit[1-9]$/.test(event.code) ? all[Number(event.key) - 1] : undefined;
      if (chosen === undefined || chosen === driver.driven.peek()?.pilot || other !== undefined) return;
      const stick = pilots.byStick.find(({ pilot }) => pilot === chosen);
      if (stick === undefined && !pilots.byThemselves.includes(chosen)) return;
      void (stick === undefined ? start(chosen) : begin(stick, false));
    };
    addEventListener('keydown', onKey);
    return () => removeEventListener('keydown', onKey);
  });
  return (
    <section class="drive-page">
      <div class="tools">
        <h1>Drive robot {robot.system}</h1>
        {driven === undefined ? (
          pilots.byStick.map((each) =>
            other === undefined ? (
              <button
                key={each.pilot.address}
                type="button"
                class="primary"
                aria-keyshortcuts={keyOf(each.pilot)}
                {...needs('lease', { disabled: busy.value, title: `Key ${keyOf(each.pilot)}` })}
                onClick={() => void begin(each, false)}
              >
                Drive with {nameOf(console, each.pilot.address)}
              </button>
            ) : (
              <HoldButton
                key={each.pilot.address}
                deed="lease"
                time={takeOverTime}
                disabled={busy.value}
                action={() => void begin(each, true)}
              >
                Take over with {nameOf(console, each.pilot.address)}
              </HoldButton>
            ),
          )
        ) : (
          <button type="button" disabled={busy.value} onClick={() => void end()}>
            Release
          </button>
        )}
        {other === undefined &&
          pilots.byThemselves.map((pilot) => (
            <button
              key={pilot.address}
              type="button"
              aria-keyshortcuts={keyOf(pilot)}
              {...needs('lease', { disabled: busy.value, title: `The robot drives by itself; key ${keyOf(pilot)}` })}
              onClick={() => void start(pilot)}
            >
              Start {nameOf(console, pilot.address)}
            </button>
          ))}
        {busy.value && <span role="status">One moment …</span>}
        <span class="small" role="status">
          {driven !== undefined ? 'You drive.' : report.value}
          {other !== undefined &&
            `${whoIs(other.holder, console.leases.name.value)} drives this robot, for ${age(other.age_s)}.`}
        </span>
        <span class="grow" />
        {driven === undefined && <YourName />}
        <label>
          Speed <strong>{speed.value} %</strong>{' '}
          <input
            type="range"
            min="10"
            max="100"
            step="10"
            value={speed.value}
            onInput={(event) => (speed.value = Number(event.currentTarget.value))}
          />
        </label>
      </div>
      <Hindrance deed="lease" />
      {trouble.value !== '' && (
        <p class="notice bad" role="alert">
          {trouble.value}
        </p>
      )}
      {pilots.silent.length > 0 && (
        <p class="notice" role="status">
          {pilots.silent.map(({ address }) => nameOf(console, address)).join(', ')} does not answer; asking again.
        </p>
      )}
      {pilots.isAsked && pilots.byStick.length + pilots.silent.length === 0 && (
        <p class="notice">
          None of its pilots listens to a joystick: start a <code>PilotJoystick</code> for it.
        </p>
      )}
      <div class="drive-views">
        <Views robot={robot} />
        <Operation robot={robot} active={driven !== undefined} speed={speed} endPilot={() => void end()} />
      </div>
    </section>
  );
}

// Ends when the page is left.
function useDriver(robot: Robot, lost: (why: string) => void): Driver {
  const console = useConsole();
  const now = useRef({ robot, lost });
  now.current = { robot, lost };
  const driver = useMemo(() => {
    const ended = (why: string) => {
      made.lose();
      now.current.lost(why);
    };
    const made = new Driver({
      begin: (pilot, over) => beginDriving(console, now.current.robot, pilot, { over, ended }),
      end: (pilot) => endDriving(console, now.current.robot, pilot),
    });
    return made;
  }, []);
  useEffect(() => () => driver.leave(), []);
  return driver;
}

// Those that do not answer are asked again.
function usePilots(robot: Robot, signature: string): Pilots & { isAsked: boolean } {
  const console = useConsole();
  const pilots = useSignal<Pilots | undefined>(undefined);
  const isConnected = console.client.connection.value.state === 'connected';
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout>;
    let ended = !isConnected;
    const ask = async () => {
      const found = await askPilots(console, robot);
      if (ended) return;
      pilots.value = found;
      if (found.silent.length > 0) timer = setTimeout(ask, askAgainTime);
    };
    if (isConnected) void ask();
    return () => {
      ended = true;
      clearTimeout(timer);
    };
  }, [signature, isConnected]);
  return { ...(pilots.value ?? { byStick: [], byThemselves: [], silent: [] }), isAsked: pilots.value !== undefined };
}

// What of the robot is in error, and why. Below the stick, which must not move under a finger.
function Troubles({ robot }: { robot: Robot }) {
  const console = useConsole();
  const bad = robot.components.filter(({ state }) => ['error', 'silent'].includes(state.value));
  if (bad.length === 0) return null;
  return (
    <ul class="drive-troubles small">
      {bad.map(({ address, state, why }) => (
        <li key={address}>
          <Lamp state={state.value} /> <strong>{nameOf(console, address)}</strong>:{' '}
          {why.value || stateWord(state.value)}
        </li>
      ))}
    </ul>
  );
}

// Another tab of this browser has the same name.
const whoIs = (holder: string, own: string) => (holder === own ? `Another page under your name (${own})` : holder);

function YourName() {
  const { name } = useConsole().leases;
  return (
    <label>
      Your name{' '}
      <input
        class="name"
        title="Others see who drives"
        value={name.value}
        onChange={({ currentTarget: input }) => {
          if (input.value.trim() !== '') name.value = fittingName(input.value.trim());
          input.value = name.value;
        }}
      />
    </label>
  );
}

// Who else drives the robot.
function useHolder(robot: Robot, asked: boolean): Lease | undefined {
  const console = useConsole();
  const holder = useSignal<Lease | undefined>(undefined);
  useEffect(() => {
    if (!asked) return;
    let isOver = false;
    const ask = () =>
      console.leases.holders([robot.system]).then(
        (found) => {
          if (!isOver) holder.value = found.get(robot.system);
        },
        () => {}, // the connection's notice says it
      );
    void ask();
    const timer = setInterval(ask, holderPeriod);
    return () => {
      isOver = true;
      holder.value = undefined;
      clearInterval(timer);
    };
  }, [robot.system, asked]);
  return holder.value;
}

function Views({ robot }: { robot: Robot }) {
  const scan = firstOf(robot, 'Scan2d') ?? firstOf(robot, 'Ladar');
  const camera = firstOf(robot, 'Camera');
  return (
    <div class="drive-sight">
      {camera !== undefined && (
        <section class="tile tile-body" aria-label="Camera">
          <CameraSight component={camera} />
        </section>
      )}
      {scan !== undefined && (
        <section class="tile tile-body" aria-label="Scan">
          <ScanSight component={scan} />
        </section>
      )}
      {camera === undefined && scan === undefined && <p class="faint">It has neither a camera nor a scanner.</p>}
    </div>
  );
}

interface OperationProperties {
  robot: Robot;
  active: boolean;
  speed: Signal<number>;
  endPilot: () => void;
}

function Operation({ robot, active, speed, endPilot }: OperationProperties) {
  const chassis = firstOf(robot, 'Chassis');
  return (
    <div class="drive-stick">
      <Stick active={active} speed={speed} endPilot={endPilot} />
      {chassis !== undefined && <ChassisSpeed component={chassis} />}
      <Troubles robot={robot} />
      <p class="small faint">
        {active
          ? 'Hold the pad, the arrow keys, W A S D, the block of digits or a gamepad’s stick. Q and E, or turning with Shift, go sideways; F1 to F4 and a gamepad’s first buttons are those of the stick. It stops when you let go; Space stops at once, any other key also ends the pilot.'
          : 'Choose a pilot above to drive.'}
      </p>
    </div>
  );
}
