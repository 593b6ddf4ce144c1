// What will change, on each host: as sentences, as text, and what is restarted for it. From here it is applied.

import { useSignal } from '@preact/signals';
import { Hindrance } from '../ui/login';
import { needs } from '../ui/needs';
import { fileOf, hostOf, keyOf } from './draft';
import { showLine } from './place';
import type { CheckedFile, Effect } from './protocol';
import { useStudio } from './workshop';

const windows = [60, 90, 180, 600]; // s, beside the least that all hosts allow
const leastWindow = 30;
const usualWindow = 90;

export function ChangesView() {
  const { studio } = useStudio();
  const changed = studio.changed.value;
  if (changed.length === 0)
    return (
      <section class="empty">
        <h2>Nothing has changed</h2>
        <p>The files on all hosts are as they are shown here. Edit in Graph, Table or Text.</p>
      </section>
    );
  const hosts = [...new Set(changed.map(hostOf))];
  return (
    <div class="changes">
      <Hindrance deed="conf_apply" />
      <ApplyForm />
      {hosts.map((host) => (
        <HostChanges key={host} host={host} />
      ))}
    </div>
  );
}

function ApplyForm() {
  const { studio } = useStudio();
  const who = useSignal(localStorage.getItem(stored) ?? '');
  const why = useSignal('');
  const window = useSignal(usualWindow);
  const least = Math.max(...studio.hosts.value.map(({ list }) => list?.change.window_min_s ?? leastWindow));
  const busy = useSignal(false);
  const errors = studio.problems.value.filter(({ severity }) => severity === 'error').length;
  const conflicts = studio.conflicts.value.length;
  const obstacle =
    conflicts > 0
      ? 'Another editor has changed a file: decide above what holds.'
      : errors > 0
        ? `${errors === 1 ? 'An error is' : `${errors} errors are`} to be mended first, see below.`
        : '';
  const apply = async (event: Event) => {
    event.preventDefault();
    localStorage.setItem(stored, who.value);
    busy.value = true;
    await studio.apply(who.value, why.value, window.value);
    busy.value = false;
  };
  return (
    <form class="box apply" onSubmit={apply} aria-label="Apply">
      <label>
        Your name{' '}
        <input required maxLength={60} value={who.value} onInput={(event) => (who.value = event.currentTarget.value)} />
      </label>
      <label class="grow">
        Why{' '}
        <input
          required
          maxLength={200}
          placeholder="see farther"
          value={why.value}
          onInput={(event) => (why.value = event.currentTarget.value)}
        />
      </label>
      <label>
        Goes back unless kept within{' '}
        <select value={window.value} onChange={(event) => (window.value = Number(event.currentTarget.value))}>
          {[least, ...windows.filter((seconds) => seconds > least)].map((seconds) => (
            <option key={seconds} value={seconds}>
              {seconds} s
            </option>
          ))}
        </select>
      </label>
      <span class="actions">
        <button
          type="submit"
          class="primary"
          {...needs('conf_apply', { disabled: busy.value || obstacle !== '' || studio.checking.value })}
        >
          {busy.value ? 'Applying …' : `Apply, undo in ${window.value} s`}
        </button>
        <button type="button" onClick={() => studio.discard()}>
          Discard all
        </button>
      </span>
      {obstacle !== '' && <p class="bad">{obstacle}</p>}
    </form>
  );
}

const stored = 'rack.who';

function HostChanges({ host }: { host: string }) {
  const { studio } = useStudio();
  const check = studio.checks.value.get(host);
  const files = check?.files.filter(({ diff, added, removed }) => diff !== '' || added + removed > 0) ?? [];
  return (
    <section class="box" aria-label={`Changes on ${host}`}>
      <h2>{host}</h2>
      {check === undefined && <p class="faint">It has not been checked yet.</p>}
      {files.map((file) => (
        <FileChanges key={file.file} host={host} file={file} />
      ))}
      {check !== undefined && check.effects.length > 0 && (
        <p class="faint">When it is applied: {check.effects.map(effectText).join(', ')}.</p>
      )}
    </section>
  );
}

const effectWords = {
  reload: (what: string) => `${what} takes it over without interruption`,
  restart: (what: string) => `${what} restarts`,
  start: (what: string) => `${what} starts`,
  stop: (what: string) => `${what} ends`,
  none: (what: string) => `${what} is not running`,
};

const effectText = ({ what, does }: Effect) => effectWords[does](what);

function FileChanges({ host, file: { file, sentences, diff, added, removed } }: { host: string; file: CheckedFile }) {
  const { studio } = useStudio();
  const key = keyOf(host, file);
  return (
    <article>
      <h3>
        {fileOf(key)} <span class="good">+{added}</span> <span class="bad">−{removed}</span>
      </h3>
      <ul class="sentences">
        {sentences.map((sentence) => (
          <li key={sentence}>{sentence}</li>
        ))}
      </ul>
      <pre class="diff">
        {diffLines(diff).map(({ text, kind }, i) => (
          <span key={`${i}${text}`} class={kind}>
            {text}
            {'\n'}
          </span>
        ))}
      </pre>
      <p class="actions">
        {studio.draft.text(key) !== null && (
          <button type="button" onClick={() => showLine(key, 0)}>
            Open the text
          </button>
        )}
        <button
          type="button"
          onClick={() => studio.propose(`Discard changes of ${file}`, [[key, studio.draft.deployedText(key)]])}
        >
          Discard
        </button>
      </p>
    </article>
  );
}

type DiffKind = 'place' | 'added' | 'removed' | 'same';

export function diffLines(diff: string): { text: string; kind: DiffKind }[] {
  return diff
    .replace(/\n$/, '')
    .split('\n')
    .filter((line) => !/^(---|\+\+\+) /.test(line) && line !== '')
    .map((text) => ({ text, kind: kinds[text[0] ?? ''] ?? 'same' }));
}

const kinds: Record<string, DiffKind> = { '@': 'place', '+': 'added', '-': 'removed' };
