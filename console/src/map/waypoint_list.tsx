// The waypoints beside the map: seen, taken back, sent.

import { useConsole } from '../app/console';
import type { Component } from '../model/fleet';
import { useAttempt } from '../ui/attempt';
import { needs } from '../ui/needs';
import { metres } from '../ui/quantities';
import type { Waypoints } from './waypoints';

export function WaypointList({ waypoints, path }: { waypoints: Waypoints; path: Component }) {
  const console = useConsole();
  const { attempt, Failure } = useAttempt();
  const list = waypoints.list.value;
  if (list.length === 0 && !waypoints.canUndo) return null;
  return (
    <section class="waypoints" aria-label="Waypoints">
      <ol>
        {list.map(({ x, y, backward }, i) => (
          <li key={`${i} ${x} ${y}`}>
            {i + 1}. {metres(x)}, {metres(y)} {backward && <span class="faint">backward</span>}
            <button
              type="button"
              class="quiet"
              aria-label={`Remove waypoint ${i + 1}`}
              onClick={() => waypoints.remove(i)}
            >
              ×
            </button>
          </li>
        ))}
      </ol>
      <p class="actions">
        <button
          type="button"
          class="primary"
          {...needs('Path.SET_RDDF')}
          onClick={() => attempt(() => waypoints.send(console, path))}
        >
          Send
        </button>
        <button type="button" disabled={!waypoints.canUndo} onClick={() => waypoints.undo()}>
          Undo
        </button>
        <button type="button" disabled={list.length === 0} onClick={() => waypoints.clear()}>
          Clear
        </button>
      </p>
      <Failure />
    </section>
  );
}
