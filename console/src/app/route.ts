// The address of a view: "#/robot/1?tile=Ladar/0". A page, its arguments, and its options. The browser's history and
// bookmarks work on it, and a layout is shared by sending it.

import { signal } from '@preact/signals';

export interface Route {
  page: string;
  arguments: string[];
  options: URLSearchParams;
}

export function parseRoute(hash: string): Route {
  const [path = '', query = ''] = hash.replace(/^#?\/?/, '').split('?', 2);
  const [page = '', ...rest] = path.split('/').map((part) => decode(part));
  return { page: page === '' ? 'fleet' : page, arguments: rest, options: new URLSearchParams(query) };
}

export function routeText({ page, arguments: rest, options }: Route): string {
  const query = options.toString();
  return `#/${[page, ...rest].map(encodeURIComponent).join('/')}${query === '' ? '' : `?${query}`}`;
}

export const route = signal(parseRoute(location.hash));

addEventListener('hashchange', () => {
  route.value = parseRoute(location.hash);
});

// `replace`: the change is no step of the history, like that of a filter.
export function go(next: Route, replace = false): void {
  if (replace) history.replaceState(null, '', routeText(next));
  else history.pushState(null, '', routeText(next));
  route.value = next;
}

export function setOption(name: string, value: string | undefined): void {
  const options = new URLSearchParams(route.value.options);
  if (value === undefined || value === '') options.delete(name);
  else options.set(name, value);
  go({ ...route.value, options }, true);
}

function decode(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}
