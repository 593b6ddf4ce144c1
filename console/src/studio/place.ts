// What the page shows, in its address: a view, and the component, router or line that was chosen.

import { go, route } from '../app/route';
import type { PlannedComponent } from './components';
import { type FileKey, keyOf } from './draft';
import type { Problem } from './protocol';

export const views = ['graph', 'table', 'text', 'budgets', 'changes', 'history'] as const;
export type View = (typeof views)[number];

export function shownView(): View {
  const wanted = route.value.options.get('view');
  return views.find((view) => view === wanted) ?? 'graph';
}

// A change of the view is a step of the browser's history.
export function show(changes: Record<string, string | undefined>): void {
  const options = new URLSearchParams(route.value.options);
  for (const [name, value] of Object.entries(changes))
    if (value === undefined) options.delete(name);
    else options.set(name, value);
  go({ ...route.value, options });
}

export const option = (name: string) => route.value.options.get(name) ?? undefined;

export const nodeId = ({ key, index }: Pick<PlannedComponent, 'key' | 'index'>) => `${key}#${index}`;

export function showLine(key: FileKey, line: number): void {
  show({ view: 'text', file: key, line: line > 0 ? `${line}` : undefined });
}

export function showProblem({ host, file, line }: Problem): void {
  if (host !== undefined) showLine(keyOf(host, file), line);
}
