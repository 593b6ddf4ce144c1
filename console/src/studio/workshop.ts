// What the views of the studio share.

import { createContext } from 'preact';
import { useContext } from 'preact/hooks';
import type { Console } from '../app/console';
import { Agents } from './agents';
import { Running } from './running';
import { Studio } from './studio';

export interface Workshop {
  studio: Studio;
  running: Running;
}

export const WorkshopContext = createContext<Workshop | undefined>(undefined);

export function useStudio(): Workshop {
  const workshop = useContext(WorkshopContext);
  if (workshop === undefined) throw new Error('no studio around this component');
  return workshop;
}

// One for each console: a draft outlives the visit of another page.
const workshops = new WeakMap<Console, Workshop>();

export function workshopOf(console: Console): Workshop {
  let workshop = workshops.get(console);
  if (workshop === undefined) {
    workshop = {
      studio: new Studio(console.client, new Agents(console.admin)),
      running: new Running(console.client),
    };
    workshops.set(console, workshop);
  }
  return workshop;
}
