// Keys that work on all pages, and their list at "?".

import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { isText } from './focus';

export interface Key {
  key: string;
  text: string;
  run: () => void;
}

const sequenceTime = 1500; // ms between "g" and the page's letter
const never = Number.NEGATIVE_INFINITY; // a page is younger than sequenceTime at first

export function Keys({ pages }: { pages: Key[] }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const begun = useSignal(never);
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      if (event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey || isText(event.target)) return;
      if (event.key === '?') return dialog.current?.showModal();
      if (event.key === '/') return focusFilter(event);
      if (event.key === 'g') {
        begun.value = event.timeStamp;
        return;
      }
      const page = pages.find(({ key }) => key === event.key);
      if (page !== undefined && event.timeStamp - begun.value < sequenceTime) page.run();
      begun.value = never;
    };
    addEventListener('keydown', onKey);
    return () => removeEventListener('keydown', onKey);
  });
  return (
    <dialog ref={dialog} aria-label="Keys" class="keys">
      <h2>Keys</h2>
      <dl>
        {pages.map(({ key, text }) => (
          <div key={key}>
            <dt>
              <kbd>g</kbd> <kbd>{key}</kbd>
            </dt>
            <dd>{text}</dd>
          </div>
        ))}
        {others.map(([keys, text]) => (
          <div key={text}>
            <dt>
              {keys.map((key) => (
                <kbd key={key}>{key}</kbd>
              ))}
            </dt>
            <dd>{text}</dd>
          </div>
        ))}
      </dl>
      <form method="dialog">
        <button type="submit">Close</button>
      </form>
    </dialog>
  );
}

const others: [string[], string][] = [
  [['Ctrl', 'K'], 'Go to a page, robot or component'],
  [['/'], 'Filter'],
  [['Shift', 'Esc'], 'Stop the robots that this page shows'],
  [['F1'], 'to F8: open the first views of a robot'],
  [['f'], 'One view on the whole page'],
  [['+', '-', 'Home'], 'On the map: zoom, all robots; the arrows move it'],
  [['Right button'], 'On the map: drag up and down to zoom; both buttons: that place into the middle'],
  [['Enter'], 'On the map with an action: choose a place, with arrows, G and H; Enter takes it'],
  [['?'], 'This list'],
];

function focusFilter(event: KeyboardEvent) {
  const filter = document.querySelector<HTMLElement>('[data-filter]');
  if (filter === null) return;
  event.preventDefault();
  filter.focus();
}
