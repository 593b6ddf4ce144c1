// Of a component that has reported an error, what follows is often the same error in other words, again and again: it is
// hidden until the component has been turned on or off, or begins anew. Pure.

import type { Level } from '../tims/gdos';

interface Text {
  sender: number;
  level: Level;
  text: string;
}

// Texts by which a component says that it begins anew; also of original programs.
const fresh = /\b(module (on|off)|initiali[sz]ed|init|terminated|started|stopped)\b/i;

// `hidden`: the number of texts that are left out.
export function firstErrors<T extends Text>(texts: readonly T[]): { shown: T[]; hidden: number } {
  const failed = new Set<number>();
  const shown = texts.filter(({ sender, level, text }) => {
    if (fresh.test(text)) failed.delete(sender);
    else if (failed.has(sender)) return false;
    if (level === 'error') failed.add(sender);
    return true;
  });
  return { shown, hidden: texts.length - shown.length };
}
