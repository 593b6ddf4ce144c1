// For controls that send something: who may not send it finds them disabled, with the reason as their title.
//
//   <button type="button" {...needs('Odometry.RESET')} onClick={reset}>

import { className, findNamed } from '../codec/catalogue';
import type { CommandName } from '../model/commands';
import { hindrance } from '../tims/login';
import { neededForQuestion, neededForType, type Right } from '../tims/rights';

// A message of a class that is known only while it is chosen.
interface OfClass {
  classId: number;
  type: number;
}

// A command to a component, or a question to a router or an agent.
export type Deed = CommandName | OfClass | 'link' | 'lease' | 'fault' | 'conf_apply';

interface Control {
  disabled?: boolean; // for another reason
  title?: string;
}

export function neededFor(deed: Deed): Right {
  if (typeof deed === 'object') return neededForType(deed.type, className(deed.classId));
  const message = findNamed(deed);
  return message === undefined ? neededForQuestion(deed) : neededForType(message.type, deed.split('.')[0]);
}

export function needs(deed: Deed, { disabled = false, title }: Control = {}): Control {
  const why = hindrance(neededFor(deed));
  if (why !== '') return { disabled: true, title: why };
  return title === undefined ? { disabled } : { disabled, title };
}
