// The options of a router: those that its file sets, and all others by section.

import { useSignal } from '@preact/signals';
import { FilterBox } from '../ui/filter_box';
import { Icon } from '../ui/icons';
import { isTable, valueText } from './components';
import { type FileKey, fileOf, hostOf } from './draft';
import type { Operation, RouterOption, Toml, TomlTable } from './protocol';
import { ValueInput } from './value_input';
import { useStudio } from './workshop';

export function RouterForm({ file }: { file: FileKey }) {
  const { studio } = useStudio();
  const filter = useSignal('');
  const values = studio.parsed.value.get(file)?.values ?? {};
  const options = studio.options.value;
  const plain = options.filter(({ list, key }) => !list && key.includes(filter.value.toLowerCase()));
  const set = plain.filter(({ key }) => valueAt(values, key) !== undefined);
  const sections = [...new Set(plain.map(({ key }) => sectionOf(key)))];
  return (
    <>
      <FilterBox label="Filter options" value={filter.value} change={(text) => (filter.value = text)} />
      {set.length > 0 && <Options file={file} options={set} values={values} prefix="" />}
      <List file={file} name="link" title="Link" values={values} />
      <List file={file} name="route" title="Route" values={values} />
      {sections.map((section) => {
        const rest = plain.filter((each) => sectionOf(each.key) === section && !set.includes(each));
        if (rest.length === 0) return null;
        return (
          <details key={section} open={filter.value !== ''}>
            <summary>[{section}]</summary>
            <Options file={file} options={rest} values={values} prefix="" />
          </details>
        );
      })}
    </>
  );
}

const sectionOf = (key: string) => key.split('.')[0] ?? key;

// Items of [[link]] or [[route]].
function List({ file, name, title, values }: { file: FileKey; name: string; title: string; values: TomlTable }) {
  const { studio } = useStudio();
  const items = Array.isArray(values[name]) ? (values[name] as Toml[]) : [];
  const options = studio.options.value
    .filter(({ list, key }) => list && key.startsWith(`${name}.`))
    .map((each) => ({ ...each, key: each.key.slice(name.length + 1) }));
  const operate = (label: string, operation: Operation) =>
    void studio.operate(`${label} on ${hostOf(file)}`, [{ key: file, operations: [operation] }]);
  return (
    <>
      {items.map((item, i) => {
        const table = isTable(item) ? item : {};
        const path = `${name}[${i}]`;
        return (
          <details key={path}>
            <summary>
              {title} {valueText(table.to ?? table.name ?? table.match ?? table.kind ?? i)}
            </summary>
            <Options file={file} options={options} values={table} prefix={`${path}.`} />
            <button type="button" onClick={() => operate(`Remove a ${name}`, { op: 'remove', path })}>
              Remove this {name}
            </button>
          </details>
        );
      })}
      {options.length > 0 && name === 'link' && (
        <p class="actions">
          <button
            type="button"
            onClick={() =>
              operate('Add a link', { op: 'add', path: name, value: { kind: 'super', to: '127.0.0.1:2010' } })
            }
          >
            <Icon name="plus" /> Add a link
          </button>
        </p>
      )}
    </>
  );
}

interface OptionsProperties {
  file: FileKey;
  options: RouterOption[];
  values: TomlTable;
  prefix: string; // of the paths
}

function Options({ file, options, values, prefix }: OptionsProperties) {
  return (
    <ul class="parameter-list">
      {options.map((each) => (
        <OptionItem key={each.key} file={file} info={each} path={prefix + each.key} value={valueAt(values, each.key)} />
      ))}
    </ul>
  );
}

interface ItemProperties {
  file: FileKey;
  info: RouterOption;
  path: string;
  value: Toml | undefined;
}

function OptionItem({ file, info, path, value }: ItemProperties) {
  const { studio } = useStudio();
  const problem = studio.problems.value.find(
    (each) => each.host === hostOf(file) && each.file === fileOf(file) && each.path === path,
  );
  const usual = (info.default ?? '').replace(/^"(.*)"$/, '$1');
  const written = valueText(value);
  const change = (text: string) => {
    const operation: Operation =
      text === '' ? { op: 'remove', path } : { op: 'set', path, value: optionValue(info, text) };
    const label = `${path} of ${hostOf(file)}: ${written ?? `default ${usual}`} → ${text || `default ${usual}`}`;
    void studio.operate(label, [{ key: file, operations: [operation] }]);
  };
  const id = `about-${path}`;
  return (
    <li class={value === undefined ? 'unset' : ''}>
      <span class="parameter-name">{info.key}</span>
      <span class="parameter-value">
        <ValueInput
          label={path}
          info={{ type: 'text', ...choicesOf(info) }}
          value={written}
          usual={usual}
          invalid={problem !== undefined}
          describedBy={id}
          change={change}
        />
        {value !== undefined && (
          <button type="button" class="quiet" aria-label={`Use the default of ${path}`} onClick={() => change('')}>
            <Icon name="close" />
          </button>
        )}
      </span>
      <div id={id} class="small faint">
        {problem !== undefined && <p class="bad">{problem.text}</p>}
        <p>
          {value !== undefined && usual !== '' && `default ${usual}; `}
          {info.range !== undefined && !enumerations.includes(info.kind) && info.range !== '' && `${info.range}; `}
          {info.reload === false && 'needs a restart of the router; '}
          {info.help.replace(' Changes need a restart.', '')}
        </p>
      </div>
    </li>
  );
}

const isBoolean = ({ kind }: RouterOption) => kind === 'true or false';
const enumerations = ['level', 'role', 'kind'];

function choicesOf(info: RouterOption): { choices?: { value: string }[] } {
  const values = isBoolean(info)
    ? ['true', 'false']
    : enumerations.includes(info.kind)
      ? info.range?.split(', ')
      : undefined;
  return values === undefined ? {} : { choices: values.map((value) => ({ value })) };
}

// As it stands in the file: numbers and truths without quotes, lists in brackets.
export function optionValue({ kind }: Pick<RouterOption, 'kind'>, text: string): Toml {
  if (kind === 'true or false') return text === 'true';
  if (kind.startsWith('list'))
    return text
      .replace(/[[\]"]/g, '')
      .split(',')
      .map((part) => part.trim())
      .filter((part) => part !== '');
  return kind.startsWith('number') && text.trim() !== '' && Number.isFinite(Number(text)) ? Number(text) : text;
}

export function valueAt(values: TomlTable, path: string): Toml | undefined {
  let value: Toml | undefined = values;
  for (const key of path.split('.')) value = isTable(value) ? value[key] : undefined;
  return value;
}
