// Ctrl+K: go to any page, robot or component by typing a part of its name.

import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { className } from '../codec/catalogue';
import { type Console, nameOf, useConsole } from './console';
import { go, parseRoute } from './route';

interface Target {
  text: string;
  path: string; // without "#/"
}

const shownMax = 12;

export function Palette({ pages }: { pages: { name: string; title: string }[] }) {
  const console = useConsole();
  const dialog = useRef<HTMLDialogElement>(null);
  const text = useSignal('');
  const marked = useSignal(0);
  const isOpen = useSignal(false); // closed, it does not follow a fleet of thousands of components
  useEffect(() => {
    const open = (event: KeyboardEvent) => {
      if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== 'k') return;
      event.preventDefault();
      text.value = '';
      marked.value = 0;
      isOpen.value = true;
      dialog.current?.showModal();
    };
    addEventListener('keydown', open);
    return () => removeEventListener('keydown', open);
  }, []);
  const found = isOpen.value
    ? targets(console, pages)
        .filter((target) => matches(target.text, text.value))
        .slice(0, shownMax)
    : [];
  const choose = (target: Target | undefined) => {
    if (target === undefined) return;
    dialog.current?.close();
    go(parseRoute(target.path));
  };
  const onKey = (event: KeyboardEvent) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step !== undefined) marked.value = Math.min(found.length - 1, Math.max(0, marked.value + step));
    else if (event.key === 'Enter') choose(found[marked.value]);
    else return;
    event.preventDefault();
  };
  return (
    <dialog ref={dialog} class="palette" aria-label="Go to" onClose={() => (isOpen.value = false)}>
      <input
        aria-label="Page, robot or component"
        placeholder="Page, robot or component"
        role="combobox"
        aria-expanded="true"
        aria-controls="palette-list"
        aria-activedescendant={found.length > 0 ? `palette-${marked.value}` : undefined}
        value={text.value}
        onInput={(event) => {
          text.value = event.currentTarget.value;
          marked.value = 0;
        }}
        onKeyDown={onKey}
      />
      <div id="palette-list" role="listbox" aria-label="Found">
        {found.map((target, i) => (
          <button
            key={target.path}
            id={`palette-${i}`}
            type="button"
            role="option"
            class="quiet"
            tabIndex={-1}
            aria-selected={i === marked.value}
            onClick={() => choose(target)}
          >
            {target.text}
          </button>
        ))}
        {found.length === 0 && <p class="faint">Nothing is called like this.</p>}
      </div>
    </dialog>
  );
}

function targets(console: Console, pages: { name: string; title: string }[]): Target[] {
  const robots = console.fleet.robots.value;
  return [
    ...pages.map(({ name, title }) => ({ text: title, path: name })),
    ...robots.flatMap(({ system }) => [
      { text: `Robot ${system}`, path: `robot/${system}` },
      { text: `Drive robot ${system}`, path: `drive/${system}` },
    ]),
    ...robots.flatMap(({ system, components }) =>
      components.map(({ address, classId, instance }) => ({
        text: nameOf(console, address),
        path: `robot/${system}?tiles=${className(classId) ?? classId}/${instance}`,
      })),
    ),
  ];
}

// All words, in any order.
function matches(text: string, wanted: string): boolean {
  const lower = text.toLowerCase();
  return wanted
    .toLowerCase()
    .split(/\s+/)
    .every((word) => lower.includes(word));
}
