// STOP, wherever the page has it.

import { classId } from '../codec/catalogue';
import type { Client } from '../tims/client';
import { noPilot, stopCommand } from './commands';
import type { Fleet } from './fleet';

// Chassis stop by themselves when nobody may drive them; their pilots are turned off, so that none takes it again,
// also those that were off when they were asked last. Throws which robots it knows nothing of that moves, when the
// others have been told, and what did not obey.
export async function stopRobots(
  client: Pick<Client, 'call'>,
  fleet: Pick<Fleet, 'robot'>,
  systems: number[],
): Promise<void> {
  if (systems.length === 0) throw new Error('No robot is listed: none was stopped.');
  const pilot = classId('Pilot');
  const chassis = classId('Chassis');
  const calls: Promise<unknown>[] = [];
  const unknown: number[] = [];
  for (const system of systems) {
    const before = calls.length;
    for (const component of fleet.robot(system)?.components ?? []) {
      if (component.classId === chassis)
        calls.push(stopCommand(client, component, 'Chassis.SET_ACTIVE_PILOT', { activePilot: noPilot }));
      if (component.classId === pilot) calls.push(stopCommand(client, component, 'OFF'));
    }
    if (calls.length === before) unknown.push(system);
  }
  const failures = (await Promise.allSettled(calls)).flatMap((result) =>
    result.status === 'rejected' ? [(result.reason as Error).message] : [],
  );
  if (unknown.length > 0) failures.unshift(unknownText(unknown));
  if (failures.length > 0) throw new Error([...new Set(failures)].join('; '));
}

const unknownText = (systems: number[]) =>
  `Neither chassis nor pilot of robot ${systems.join(', ')} is listed: it was not stopped`;
