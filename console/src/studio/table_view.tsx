// All parameters of all components in one table: what is set in the file, beside the default and what runs. Cells of
// a spread sheet can be pasted.

import { useSignal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { setOption } from '../app/route';
import { FilterBox } from '../ui/filter_box';
import { type ParameterLine, type PlannedComponent, parameterLines, sameValue, tomlOf } from './components';
import { fileValue, useRunningValues } from './live';
import { isSeveral, paste } from './paste';
import { nodeId, option, show } from './place';
import type { Operation } from './protocol';
import type { FileOperations, Studio } from './studio';
import { ValueInput } from './value_input';
import { useStudio } from './workshop';

interface Row {
  component: PlannedComponent;
  line: ParameterLine;
  running: string | undefined;
}

const rowsAtOnce = 150;

export function TableView() {
  const { studio } = useStudio();
  const table = useRef<HTMLTableElement>(null);
  const count = useSignal(rowsAtOnce);
  const filter = option('filter') ?? '';
  const which = option('rows') ?? 'set';
  const valuesOf = useRunningValues(studio.components.value);
  const rows = studio.components.value
    .flatMap((component): Row[] =>
      parameterLines(component, studio.programOf(component)).map((line) => ({
        component,
        line,
        running: valuesOf(component).get(line.info.name),
      })),
    )
    .filter((row) => isWanted(row, which) && matches(row, filter));
  const shownRows = rows.slice(0, count.value);
  const focus = (row: number) => {
    const box = table.current?.querySelectorAll<HTMLElement>('tbody input, tbody select')[row];
    box?.focus();
    return box !== undefined;
  };
  return (
    <div class="table-view">
      <div class="tools">
        <FilterBox
          label="Filter components and parameters"
          value={filter}
          change={(text) => setOption('filter', text)}
        />
        <label>
          Show{' '}
          <select value={which} onChange={(event) => show({ rows: event.currentTarget.value })}>
            <option value="set">those set in a file</option>
            <option value="differs">those that run with another value</option>
            <option value="all">all</option>
          </select>
        </label>
        <span class="faint small">
          {rows.length === 1 ? '1 value' : `${rows.length} values`}. Cells of a spread sheet can be pasted.
        </span>
      </div>
      <div class="scroll">
        <table class="list values-table" ref={table}>
          <thead>
            <tr>
              <th scope="col">Host</th>
              <th scope="col">Component</th>
              <th scope="col">Parameter</th>
              <th scope="col">File</th>
              <th scope="col">Default</th>
              <th scope="col">Running</th>
            </tr>
          </thead>
          <tbody>
            {shownRows.map((row, i) => (
              <TableRow
                key={`${nodeId(row.component)} ${row.line.info.name}`}
                row={row}
                pasted={(text) => pasteRows(studio, rows, i, text)}
                move={(step) => focus(i + step)}
              />
            ))}
          </tbody>
        </table>
        {rows.length > shownRows.length && (
          <p class="actions">
            <button type="button" onClick={() => (count.value += rowsAtOnce)}>
              Show {Math.min(rowsAtOnce, rows.length - shownRows.length)} more of {rows.length}
            </button>
          </p>
        )}
      </div>
    </div>
  );
}

function TableRow({
  row,
  pasted,
  move,
}: {
  row: Row;
  pasted: (text: string) => boolean;
  move: (step: number) => boolean;
}) {
  const { studio } = useStudio();
  const { component, line, running } = row;
  const { info, file, usual } = line;
  const problem = problemOf(studio, component, line);
  const id = `problem-${nodeId(component)}-${info.name}`;
  return (
    <tr>
      <td>{component.host}</td>
      <td>{component.title}</td>
      <th scope="row" title={info.help}>
        {info.name}
        <span class="of faint small">
          {component.title} on {component.host}
        </span>
      </th>
      <td class="edit">
        <ValueInput
          label={`${info.name} of ${component.title} on ${component.host}`}
          info={info}
          value={file}
          usual={usual}
          invalid={problem !== undefined}
          describedBy={id}
          change={(text) => setValue(studio, component, line, text)}
          pasted={pasted}
          move={move}
        />{' '}
        {info.unit}
        {problem !== undefined && (
          <p class="bad small" id={id}>
            {problem}
          </p>
        )}
      </td>
      <td class="faint">{usual}</td>
      <td class={differs(row) ? 'warn' : ''}>{running ?? <span class="faint">–</span>}</td>
    </tr>
  );
}

export function setValue(studio: Studio, component: PlannedComponent, line: ParameterLine, text: string): void {
  const before = line.file ?? `default ${line.usual}`;
  const label = `${component.title} ${line.info.name}: ${before} → ${text === '' ? `default ${line.usual}` : text}`;
  void studio.operate(label, [{ key: component.key, operations: [operationOf(line, text)] }]);
}

// An empty box: the default, which stands in no file.
function operationOf({ path, info, file }: ParameterLine, text: string): Operation {
  if (text === '' && file !== undefined) return { op: 'remove', path };
  return { op: 'set', path, value: tomlOf(text, info.type) };
}

export function problemOf(studio: Studio, component: PlannedComponent, { path }: ParameterLine): string | undefined {
  const file = component.key.slice(component.host.length + 1);
  return studio.problems.value.find(
    (problem) => problem.host === component.host && problem.file === file && problem.path === path,
  )?.text;
}

function pasteRows(studio: Studio, rows: Row[], first: number, text: string): boolean {
  if (!isSeveral(text)) return false;
  const { values, unknown } = paste(
    text,
    rows.map(({ line }) => line.info.name),
    first,
  );
  const files = new Map<string, FileOperations>();
  for (const { row, value } of values) {
    const { component, line } = rows[row]!;
    const file = files.get(component.key) ?? { key: component.key, operations: [] };
    file.operations.push(operationOf(line, value));
    files.set(component.key, file);
  }
  void studio.operate(`Paste ${values.length} values`, [...files.values()]).then(() => {
    if (unknown.length > 0) studio.failure.value = `There is no row for ${unknown.join(', ')}`;
  });
  return true;
}

function differs({ component, line, running }: Row): boolean {
  if (running === undefined) return false;
  return !sameValue(running, fileValue(line.file, component) ?? line.usual);
}

function isWanted(row: Row, which: string): boolean {
  if (which === 'set') return row.line.file !== undefined;
  return which === 'all' || differs(row);
}

// All words, in any order.
function matches({ component, line }: Row, filter: string): boolean {
  const text = `${component.host} ${component.title} ${line.info.name}`.toLowerCase();
  return filter
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}
