// STOP: turns the pilots of the robots off that the page shows, and takes the right to drive from them.

import { useEffect } from 'preact/hooks';
import { type Console, useConsole } from '../app/console';
import { route } from '../app/route';
import { stopRobots } from '../model/stop';
import { useAttempt } from './attempt';
import { Icon } from './icons';
import { needs } from './needs';

// The robots that the page is about; none: all.
export function shownRobots(console: Console): number[] {
  const { page, arguments: rest, options } = route.value;
  const text = page === 'robot' || page === 'drive' ? rest[0] : options.get('robots');
  const numbers = (text ?? '')
    .split(',')
    .filter((part) => part !== '')
    .map(Number);
  return numbers.length > 0 ? numbers : console.fleet.robots.value.map(({ system }) => system);
}

export function StopButton() {
  const console = useConsole();
  const { attempt, Failure } = useAttempt();
  const systems = shownRobots(console);
  const stop = () => attempt(() => stopRobots(console.client, console.fleet, systems));
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      if (event.key === 'Escape' && event.shiftKey) void stop();
    };
    addEventListener('keydown', onKey);
    return () => removeEventListener('keydown', onKey);
  });
  const what = systems.length === 1 ? `robot ${systems[0]}` : 'all robots';
  return (
    <>
      <Failure />
      <button
        type="button"
        class="stop"
        onClick={stop}
        aria-label={`Stop ${what}`}
        {...needs('Chassis.SET_ACTIVE_PILOT', { title: `Stop ${what} (Shift+Esc)` })}
      >
        <Icon name="stop" /> STOP
      </button>
    </>
  );
}
