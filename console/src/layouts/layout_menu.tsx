// The menu of layouts: keeps the page as it is, leads to those that were kept, and exchanges them by files.

import { useSignal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { route, routeText } from '../app/route';
import { Icon } from '../ui/icons';
import { saveFile } from '../ui/save';
import { importLayouts, keepLayout, layouts, layoutsFile, removeLayout } from './layouts';

export function LayoutMenu() {
  const name = useSignal('');
  const report = useSignal('');
  const file = useRef<HTMLInputElement>(null);
  const keep = (event: Event) => {
    event.preventDefault();
    const chosen = name.value.trim();
    if (chosen === '') return;
    keepLayout({ name: chosen, address: routeText(route.value) });
    report.value = `Kept as “${chosen}”.`;
    name.value = '';
  };
  const load = async ({ currentTarget }: { currentTarget: HTMLInputElement }) => {
    const text = await currentTarget.files?.[0]?.text();
    currentTarget.value = '';
    if (text === undefined) return;
    try {
      const { layouts: read, remarks } = importLayouts(text);
      report.value = [`${read.length} layouts read`, ...remarks].join('; ');
    } catch (error) {
      report.value = (error as Error).message;
    }
  };
  return (
    <details class="menu layouts">
      <summary aria-label="Layouts" title="Layouts">
        <Icon name="tiles" />
      </summary>
      <div>
        {layouts.value.length === 0 && <p class="faint">No layouts are kept yet.</p>}
        <ul>
          {layouts.value.map((layout) => (
            <li key={layout.name}>
              <a href={layout.address}>{layout.name}</a>
              <button
                type="button"
                class="quiet"
                aria-label={`Remove ${layout.name}`}
                onClick={() => removeLayout(layout.name)}
              >
                <Icon name="close" />
              </button>
            </li>
          ))}
        </ul>
        <form class="actions" onSubmit={keep}>
          <input
            placeholder="Name"
            aria-label="Name of this layout"
            value={name.value}
            onInput={(event) => {
              name.value = event.currentTarget.value;
            }}
          />
          <button type="submit">Keep this page</button>
        </form>
        <p class="actions">
          <button type="button" onClick={() => saveFile([layoutsFile()], 'application/json', 'layouts.json')}>
            Save to a file
          </button>
          <button type="button" onClick={() => file.current?.click()}>
            Read a file or gui.cfg
          </button>
          <input ref={file} type="file" hidden accept=".json,.cfg,text/plain" onChange={load} />
        </p>
        <p class="small" role="status">
          {report.value}
        </p>
      </div>
    </details>
  );
}
