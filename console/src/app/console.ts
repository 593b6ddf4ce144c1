// What all pages share.

import { createContext } from 'preact';
import { useContext } from 'preact/hooks';
import { className } from '../codec/catalogue';
import { followPosition } from '../map/follow';
import { GoalLists } from '../map/goals';
import { Admin } from '../model/admin';
import { storedName } from '../model/console_name';
import { Fleet } from '../model/fleet';
import { Leases } from '../model/leases';
import { Log } from '../model/log';
import { RobotsSeen } from '../model/robots_seen';
import { addressText, originalWidths, type Widths } from '../tims/address';
import { Client } from '../tims/client';

export interface Console {
  client: Client;
  admin: Admin;
  fleet: Fleet;
  leases: Leases;
  log: Log;
  goals: GoalLists;
  seen: RobotsSeen;
}

export function makeConsole(worker: Worker, url: string): Console {
  const client = new Client(worker, url);
  const admin = new Admin(client);
  const fleet = new Fleet(client, admin);
  return {
    client,
    admin,
    fleet,
    leases: new Leases(client, admin, storedName()),
    log: new Log(client, fleet),
    goals: new GoalLists(followPosition(client, fleet)),
    seen: new RobotsSeen(localStorage),
  };
}

export const ConsoleContext = createContext<Console | undefined>(undefined);

export function useConsole(): Console {
  const console = useContext(ConsoleContext);
  if (console === undefined) throw new Error('no console around this component');
  return console;
}

export function widthsOf({ client }: Console): Widths {
  return client.connection.value.router?.widths ?? originalWidths;
}

// "Ladar(3/0)"
export function nameOf(console: Console, address: number): string {
  return addressText(address, widthsOf(console), className);
}
