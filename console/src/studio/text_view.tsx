// The files as they are: whoever likes text types there, and sees at once what is wrong in which line.

import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { type FileKey, fileOf, hostOf, keyOf } from './draft';
import { option, show, showLine } from './place';
import type { Problem } from './protocol';
import { ProblemLine } from './status_bar';
import { placeOf, type Studio } from './studio';
import { shown } from './text';
import { useStudio } from './workshop';

export function TextView() {
  const { studio } = useStudio();
  void studio.revision.value;
  const keys = studio.draft.keys;
  const wanted = option('file') ?? option('at')?.split('#')[0];
  const key = keys.find((each) => each === wanted) ?? keys[0];
  return (
    <div class="text-view">
      <div class="tools">
        <label>
          File{' '}
          <select value={key ?? ''} onChange={(event) => show({ file: event.currentTarget.value, line: undefined })}>
            {[...new Set(keys.map(hostOf))].map((host) => (
              <optgroup key={host} label={host}>
                {keys
                  .filter((each) => hostOf(each) === host)
                  .map((each) => (
                    <option key={each} value={each}>
                      {host}: {fileOf(each)}
                      {studio.draft.isChanged(each) ? ' (changed)' : ''}
                    </option>
                  ))}
              </optgroup>
            ))}
          </select>
        </label>
        {key !== undefined && (
          <button type="button" onClick={() => studio.propose(`Remove ${fileOf(key)}`, [[key, null]])}>
            Remove this file
          </button>
        )}
        <span class="grow" />
        <NewFile studio={studio} />
      </div>
      {key !== undefined && <Editor key={key} file={key} />}
    </div>
  );
}

function Editor({ file }: { file: FileKey }) {
  const { studio } = useStudio();
  const area = useRef<HTMLTextAreaElement>(null);
  const gutter = useRef<HTMLPreElement>(null);
  const text = shown(studio.draft.text(file) ?? '');
  const problems = studio.problems.value.filter(
    (problem) => problem.host !== undefined && keyOf(problem.host, problem.file) === file,
  );
  const line = Number(option('line') ?? 0);
  useEffect(() => {
    if (area.current !== null && line > 0) choose(area.current, line);
  }, [line, problems.length === 0]);
  return (
    <>
      <div class="editor">
        <pre ref={gutter} class="gutter" aria-hidden="true">
          {text.split('\n').map((_, i) => (
            <span key={i} class={markOf(problems, i + 1)}>
              {i + 1}
              {'\n'}
            </span>
          ))}
        </pre>
        <textarea
          ref={area}
          aria-label={`${fileOf(file)} on ${hostOf(file)}`}
          spellcheck={false}
          autocapitalize="off"
          autocomplete="off"
          wrap="off"
          value={text}
          aria-invalid={problems.some(({ severity }) => severity === 'error')}
          aria-describedby="text-problems"
          onInput={(event) => studio.type(file, event.currentTarget.value)}
          onScroll={(event) => {
            if (gutter.current !== null) gutter.current.scrollTop = event.currentTarget.scrollTop;
          }}
        />
      </div>
      <ul class="problems" id="text-problems" aria-label={`Problems of ${fileOf(file)}`} hidden={problems.length === 0}>
        {problems.map((problem) => (
          <ProblemLine key={`${placeOf(problem)} ${problem.text}`} problem={problem} />
        ))}
      </ul>
    </>
  );
}

function markOf(problems: Problem[], line: number): string {
  const here = problems.filter((problem) => problem.line === line);
  if (here.length === 0) return '';
  return here.some(({ severity }) => severity === 'error') ? 'bad' : 'warn';
}

// Selects a line and brings it into sight.
function choose(area: HTMLTextAreaElement, line: number) {
  const lines = area.value.split('\n');
  const begin = lines.slice(0, line - 1).reduce((sum, each) => sum + each.length + 1, 0);
  area.focus();
  area.setSelectionRange(begin, begin + (lines[line - 1]?.length ?? 0));
  const height = area.scrollHeight / lines.length;
  area.scrollTop = Math.max(0, (line - 4) * height);
}

function NewFile({ studio }: { studio: Studio }) {
  const hosts = studio.hosts.value.filter(({ list }) => list !== undefined);
  const name = useSignal('');
  const host = useSignal('');
  const add = (event: Event) => {
    event.preventDefault();
    const at = hosts.find((each) => each.name === host.value) ?? hosts[0];
    if (at === undefined) return;
    const key = keyOf(at.name, `robots/${name.value}.toml`);
    if (studio.draft.text(key) === null) {
      const text = `name = "${name.value}"\nsystem = ${at.list?.router.system ?? 0}\n`;
      studio.propose(`New ${fileOf(key)} on ${at.name}`, [[key, text]]);
    }
    name.value = '';
    showLine(key, 0);
  };
  return (
    <details class="menu">
      <summary>New robot file</summary>
      <form onSubmit={add}>
        <label>
          Name{' '}
          <input
            required
            pattern="[A-Za-z0-9_\-]{1,31}"
            title="Letters, digits, - and _"
            value={name.value}
            onInput={(event) => (name.value = event.currentTarget.value)}
          />
        </label>
        <label>
          Host{' '}
          <select value={host.value} onChange={(event) => (host.value = event.currentTarget.value)}>
            {hosts.map((each) => (
              <option key={each.name} value={each.name}>
                {each.name}
              </option>
            ))}
          </select>
        </label>
        <button type="submit">Create</button>
      </form>
    </details>
  );
}
