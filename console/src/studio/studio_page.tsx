// Studio: the configuration of the whole fleet, as graph, table and text of the same files; checked, compared and
// applied on all hosts at once.

import { useEffect, useMemo } from 'preact/hooks';
import { useConsole } from '../app/console';
import { Icon } from '../ui/icons';
import { saveFile } from '../ui/save';
import { tar } from '../ui/tar';
import { BudgetView } from './budget_view';
import { ChangesView } from './changes_view';
import { fileOf, hostOf } from './draft';
import { GraphView } from './graph_view';
import { HistoryView } from './history_view';
import { Notices } from './notices';
import { show, shownView, type View, views } from './place';
import { StatusBar } from './status_bar';
import type { Studio } from './studio';
import { TableView } from './table_view';
import { TextView } from './text_view';
import { WorkshopContext, workshopOf } from './workshop';

const titles: Record<View, string> = {
  graph: 'Graph',
  table: 'Table',
  text: 'Text',
  budgets: 'Links',
  changes: 'Changes',
  history: 'History',
};

const bodies = {
  graph: GraphView,
  table: TableView,
  text: TextView,
  budgets: BudgetView,
  changes: ChangesView,
  history: HistoryView,
};

export function StudioPage() {
  const console = useConsole();
  const workshop = useMemo(() => workshopOf(console), [console]);
  const { studio } = workshop;
  useEffect(() => studio.watch(), [studio]);
  const view = shownView();
  const Body = bodies[view];
  return (
    <WorkshopContext.Provider value={workshop}>
      <div class="studio">
        <Tools view={view} studio={studio} />
        <Notices />
        <div class="studio-body" id="studio-view" role="tabpanel" aria-label={titles[view]}>
          {studio.hosts.value.some(({ list }) => list !== undefined) ? <Body /> : <NoAgents studio={studio} />}
        </div>
        <StatusBar />
      </div>
    </WorkshopContext.Provider>
  );
}

function Tools({ view, studio }: { view: View; studio: Studio }) {
  void studio.revision.value;
  const { undoLabel, redoLabel } = studio.draft;
  useUndoKeys(studio);
  return (
    <div class="tools studio-tools">
      <h1>Studio</h1>
      <div role="tablist" aria-label="Views of the configuration" class="tabs">
        {views.map((name) => (
          <button
            key={name}
            type="button"
            role="tab"
            aria-selected={view === name}
            aria-controls="studio-view"
            onClick={() => show({ view: name })}
          >
            {titles[name]}
            {name === 'changes' && studio.changed.value.length > 0 && (
              <span class="count">{studio.changed.value.length}</span>
            )}
          </button>
        ))}
      </div>
      <span class="grow" />
      <span class="actions">
        <button
          type="button"
          disabled={undoLabel === undefined}
          title={undoLabel === undefined ? 'Nothing to undo' : `Undo: ${undoLabel} (Ctrl+Z)`}
          onClick={() => studio.undo()}
        >
          <Icon name="undo" /> Undo
        </button>
        <button
          type="button"
          disabled={redoLabel === undefined}
          title={redoLabel === undefined ? 'Nothing to redo' : `Redo: ${redoLabel} (Ctrl+Y)`}
          onClick={() => studio.redo()}
        >
          <Icon name="redo" /> Redo
        </button>
        <button type="button" title="All files of all hosts, as a tar archive" onClick={() => exportFiles(studio)}>
          Export
        </button>
      </span>
    </div>
  );
}

// In text boxes of one line, these keys are those of the browser.
function useUndoKeys(studio: Studio) {
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      if (!(event.ctrlKey || event.metaKey) || event.altKey || event.target instanceof HTMLInputElement) return;
      const key = event.key.toLowerCase();
      if (key === 'z' && !event.shiftKey) studio.undo();
      else if (key === 'y' || (key === 'z' && event.shiftKey)) studio.redo();
      else return;
      event.preventDefault();
    };
    addEventListener('keydown', onKey);
    return () => removeEventListener('keydown', onKey);
  }, [studio]);
}

// The texts as they are shown, with the changes that are not applied yet.
function exportFiles({ draft }: Studio) {
  const now = new Date();
  const files = draft.keys.map((key) => ({ path: `${hostOf(key)}/${fileOf(key)}`, content: draft.text(key) ?? '' }));
  const day = now.toISOString().slice(0, 10);
  saveFile([tar(files, Math.floor(now.getTime() / 1000))], 'application/x-tar', `configuration-${day}.tar`);
}

function NoAgents({ studio }: { studio: Studio }) {
  if (!studio.loaded.value) return <p class="empty faint">Asking the hosts for their files …</p>;
  return (
    <section class="empty">
      <h2>No host has a configuration agent</h2>
      <p>
        The agent keeps the files of a host, checks and changes them. Start it beside the router, for example
        <br />
        <code>sudo systemctl enable --now tims-agent</code>
      </p>
    </section>
  );
}
