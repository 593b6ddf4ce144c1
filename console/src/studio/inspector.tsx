// The form of the component or router that was chosen in the graph.

import { useSignal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { useConsole } from '../app/console';
import { FilterBox } from '../ui/filter_box';
import { Icon } from '../ui/icons';
import {
  addressNameOf,
  factsOf,
  type ParameterLine,
  type PlannedComponent,
  parameterLines,
  sameValue,
} from './components';
import { fileOf, hostOf, keyOf } from './draft';
import { fileValue, liveOf, useRunningValues } from './live';
import { nodeId, option, show, showLine } from './place';
import type { InstalledProgram, Operation, ProgramInfo } from './protocol';
import { RouterForm } from './router_form';
import type { RunningValues } from './running';
import type { Host, Studio } from './studio';
import { problemOf, setValue } from './table_view';
import { ValueInput } from './value_input';
import { useStudio } from './workshop';

export function Inspector() {
  const { studio } = useStudio();
  const chosen = option('at');
  if (chosen === undefined)
    return (
      <aside class="inspector" aria-label="Chosen">
        <p class="faint">Choose a component to see and change its parameters, or a host for its router.</p>
      </aside>
    );
  const component = studio.components.value.find((each) => nodeId(each) === chosen);
  const host = studio.hosts.value.find(({ name }) => keyOf(name, 'router.toml') === chosen);
  return (
    <aside class="inspector" aria-label="Chosen">
      {component !== undefined && <ComponentForm key={chosen} component={component} />}
      {host !== undefined && <RouterPanel host={host} />}
      {component === undefined && host === undefined && <p class="faint">It is not there any more.</p>}
    </aside>
  );
}

function Close() {
  return (
    <button type="button" class="quiet" aria-label="Close the form" onClick={() => show({ at: undefined })}>
      <Icon name="close" />
    </button>
  );
}

// --- a router and what its host runs

function RouterPanel({ host }: { host: Host }) {
  const key = keyOf(host.name, 'router.toml');
  return (
    <>
      <header class="inspector-head">
        <h2>{host.name}</h2>
        <span class="grow" />
        <Close />
      </header>
      <p class="actions">
        <button type="button" onClick={() => showLine(key, 0)}>
          Text
        </button>
        <AddComponent host={host} />
      </p>
      <RouterForm file={key} />
    </>
  );
}

function AddComponent({ host }: { host: Host }) {
  const { studio } = useStudio();
  const program = useSignal('');
  const files = studio.draft.keys.filter((key) => hostOf(key) === host.name && fileOf(key).startsWith('robots/'));
  const file = useSignal(files[0] ?? '');
  const programs = useSignal<InstalledProgram[] | undefined>(undefined);
  if (files.length === 0) return null;
  const add = (event: Event) => {
    event.preventDefault();
    const operation: Operation = { op: 'add', path: 'component', value: { program: program.value.trim() } };
    void studio.operate(`Add ${program.value} on ${host.name}`, [{ key: file.value, operations: [operation] }]);
    program.value = '';
  };
  const asking = useSignal(false);
  const stop = () => {
    asking.value = false;
  };
  const ask = () => {
    if (programs.value !== undefined) return;
    asking.value = true;
    programs.value = [];
    // An agent of an earlier version does not know them: any name can be typed.
    studio.installedPrograms(host.name, (found) => (programs.value = found)).then(stop, stop);
  };
  const purpose = programs.value?.find((each) => each.program === program.value.trim())?.purpose;
  return (
    <details class="menu" onToggle={ask}>
      <summary>Add a component</summary>
      <form onSubmit={add}>
        <label>
          Program{' '}
          <input
            required
            list="studio-programs"
            value={program.value}
            onInput={(event) => (program.value = event.currentTarget.value)}
          />
        </label>
        <datalist id="studio-programs">
          {programs.value?.map((each) => (
            <option key={each.program} value={each.program}>
              {each.class}: {each.purpose}
            </option>
          ))}
        </datalist>
        <p class="small faint">{purpose ?? (asking.value ? `Asking ${host.name} for its programs …` : '')}</p>
        {files.length > 1 && (
          <label>
            File{' '}
            <select value={file.value} onChange={(event) => (file.value = event.currentTarget.value)}>
              {files.map((key) => (
                <option key={key} value={key}>
                  {fileOf(key)}
                </option>
              ))}
            </select>
          </label>
        )}
        <button type="submit">Add</button>
      </form>
    </details>
  );
}

// --- a component

function ComponentForm({ component }: { component: PlannedComponent }) {
  const { studio } = useStudio();
  const console = useConsole();
  const running = useRunningValues([component])(component);
  const program = studio.programOf(component);
  const filter = useSignal('');
  const live = liveOf(console, studio, component);
  const lines = parameterLines(component, program).filter(({ info }) =>
    info.name.toLowerCase().includes(filter.value.toLowerCase()),
  );
  const line = studio.parsed.value.get(component.key)?.places[component.path]?.[0] ?? 0;
  const remove = () => {
    show({ at: undefined });
    const operation: Operation = { op: 'remove', path: component.path };
    void studio.operate(`Remove ${component.title} from ${component.host}`, [
      { key: component.key, operations: [operation] },
    ]);
  };
  return (
    <>
      <header class="inspector-head">
        <h2>{component.title}</h2>
        <span class="faint">
          {addressNameOf(component, program) ?? component.command} on {component.host}
        </span>
        <span class="grow" />
        <Close />
      </header>
      {program !== undefined && <p class="faint small">{program.purpose}</p>}
      {program === undefined && component.program !== '' && (
        <p class="faint small">{component.program} does not describe its parameters.</p>
      )}
      <div class="actions">
        <button type="button" title={`${fileOf(component.key)}:${line}`} onClick={() => showLine(component.key, line)}>
          Text
        </button>
        <MoveMenu component={component} />
        <button type="button" onClick={remove}>
          Remove
        </button>
        {live !== undefined && (
          <a
            class="button"
            href={`#/robot/${live.system}?tiles=${addressNameOf(component, program)
              ?.replace(/\(.*\//, '/')
              .replace(')', '')}`}
          >
            See it run
          </a>
        )}
      </div>
      <Partners component={component} program={program} />
      {lines.length + filter.value.length > 8 && (
        <FilterBox label="Filter parameters" value={filter.value} change={(text) => (filter.value = text)} />
      )}
      <ul class="parameter-list">
        {[...lines]
          .sort((a, b) => rank(a) - rank(b))
          .map((each) => (
            <ParameterItem
              key={each.info.name}
              component={component}
              line={each}
              running={running}
              live={live !== undefined}
            />
          ))}
      </ul>
    </>
  );
}

// Those of the file first, then its own, then those that every component has.
const rank = ({ file, info }: ParameterLine) => (file !== undefined ? 0 : info.common ? 2 : 1);

interface ItemProperties {
  component: PlannedComponent;
  line: ParameterLine;
  running: RunningValues;
  live: boolean;
}

function ParameterItem({ component, line, running, live }: ItemProperties) {
  const { studio } = useStudio();
  const { info, file, usual } = line;
  const problem = problemOf(studio, component, line);
  const now = running.get(info.name);
  const planned = fileValue(file, component) ?? usual;
  const id = `about-${info.name}`;
  return (
    <li class={file === undefined ? 'unset' : ''}>
      <span class="parameter-name">{info.name}</span>
      <span class="parameter-value">
        <ValueInput
          label={info.name}
          info={info}
          value={file}
          usual={usual}
          invalid={problem !== undefined}
          describedBy={id}
          change={(text) => setValue(studio, component, line, text)}
        />
        {info.unit !== undefined && <span class="faint">{info.unit}</span>}
        {file !== undefined && (
          <button
            type="button"
            class="quiet"
            aria-label={`Use the default of ${info.name}`}
            title={`Use the default${usual === '' ? '' : `, ${usual}`}`}
            onClick={() => setValue(studio, component, line, '')}
          >
            <Icon name="close" />
          </button>
        )}
      </span>
      <div id={id} class="small faint">
        {problem !== undefined && <p class="bad">{problem}</p>}
        <p>
          {usual !== '' && file !== undefined && `default ${usual}; `}
          {live && now !== undefined && (
            <span class={sameValue(now, planned) ? '' : 'warn'}>running {now === '' ? 'empty' : now}; </span>
          )}
          {factsOf(info)}
        </p>
        <p>{info.help}</p>
      </div>
    </li>
  );
}

// --- whose data it uses

function Partners({ component, program }: { component: PlannedComponent; program: ProgramInfo | undefined }) {
  const { studio } = useStudio();
  const lines = parameterLines(component, program);
  const systems = lines.filter(({ info }) => info.refers !== undefined && info.part === 'system');
  return (
    <div class="partners">
      {systems.map((system) => {
        const instance = lines.find(({ info }) => info.part === 'instance' && isPair(system, info.name));
        return (
          <Partner key={system.info.name} studio={studio} component={component} system={system} instance={instance} />
        );
      })}
    </div>
  );
}

const stem = (name: string) => name.replace(/(Sys|Inst)$/, '');
const isPair = ({ info }: ParameterLine, name: string) => stem(info.name) === stem(name);

interface PartnerProperties {
  studio: Studio;
  component: PlannedComponent;
  system: ParameterLine;
  instance: ParameterLine | undefined;
}

function Partner({ studio, component, system, instance }: PartnerProperties) {
  const wanted = system.info.refers ?? '';
  const valueNow = (line: ParameterLine | undefined) => fileValue(line?.file, component) ?? line?.usual ?? '0';
  const now = `${valueNow(system)}/${valueNow(instance)}`;
  const candidates = studio.components.value.filter((each) => `${studio.programOf(each)?.class}` === wanted);
  const values = candidates.map((each) => `${each.system}/${each.instance}`);
  const choose = (value: string) => {
    const [chosenSystem = '', chosenInstance = ''] = value.split('/');
    const own = chosenSystem === `${component.system}`;
    const operations: Operation[] = [
      { op: 'set', path: system.path, value: own ? '{system}' : Number(chosenSystem) },
      ...(instance === undefined || chosenInstance === valueNow(instance)
        ? []
        : [{ op: 'set' as const, path: instance.path, value: Number(chosenInstance) }]),
    ];
    const label = `${component.title} uses ${wanted}(${value})`;
    void studio.operate(label, [{ key: component.key, operations }]);
  };
  return (
    <label>
      Its {stem(system.info.name)}{' '}
      <select value={now} onChange={(event) => choose(event.currentTarget.value)}>
        {!values.includes(now) && (
          <option value={now}>{isNone(now) ? 'none' : `${wanted}(${now}), which nobody has`}</option>
        )}
        {candidates.map((each) => (
          <option key={nodeId(each)} value={`${each.system}/${each.instance}`}>
            {wanted}({each.system}/{each.instance}) on {each.host}
          </option>
        ))}
      </select>
    </label>
  );
}

const isNone = (value: string) => value.endsWith('/-1');

// --- to another host

function MoveMenu({ component }: { component: PlannedComponent }) {
  const { studio } = useStudio();
  const menu = useRef<HTMLDetailsElement>(null);
  const hosts = studio.hosts.value.filter(({ list }) => list !== undefined);
  const targets = hosts.flatMap(({ name }) => {
    const files = studio.draft.keys.filter((key) => hostOf(key) === name && fileOf(key).startsWith('robots/'));
    const keys = files.length > 0 ? files : [keyOf(name, fileOf(component.key))];
    return keys.filter((key) => key !== component.key);
  });
  if (targets.length === 0) return null;
  const move = async (target: string) => {
    if (menu.current !== null) menu.current.open = false;
    if (await studio.move(component, target, component.system)) show({ view: 'changes', at: undefined });
  };
  return (
    <details class="menu" ref={menu}>
      <summary>Move to …</summary>
      <div>
        {targets.map((key) => (
          <button key={key} type="button" onClick={() => void move(key)}>
            {hostOf(key)} <span class="faint small">{fileOf(key)}</span>
          </button>
        ))}
      </div>
    </details>
  );
}
