// The parameters of a component: seen, changed, undone. A value is sent with Enter or by leaving its field, never
// while it is typed.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { useConsole } from '../app/console';
import { decodeMessage, encodeMessage } from '../codec/catalogue';
import { describe, type ParameterDescription } from '../model/description';
import type { Component } from '../model/fleet';
import { types } from '../tims/header';
import { useAttempt } from './attempt';
import { CheckBox } from './check_box';
import { needs } from './needs';

export interface Parameter {
  name: string;
  type: number; // 0 int, 1 text, 2 float
  valueInt: number;
  valueFloat: number;
  valueString: string;
}

interface Change {
  name: string;
  from: string;
  to: string;
}

// When a new value takes effect.
const effectWords = { now: '', on: 'at the next ON', start: 'at the next start' };

export function Parameters({ component }: { component: Component }) {
  const { client } = useConsole();
  const parameters = useSignal<Parameter[] | undefined>(undefined);
  const descriptions = useSignal<Map<string, ParameterDescription>>(new Map());
  const filter = useSignal('');
  const onlyChanged = useSignal(false);
  const { attempt, Failure } = useAttempt();
  const changes = useSignal<Change[]>([]);

  const load = async () => {
    const answer = await client.call(component.address, types.getParam);
    if (answer.type !== types.param) throw new Error('it does not list its parameters');
    const list = decodeMessage(component.classId, types.param, answer.body, answer.flags) as {
      parameters: Parameter[];
    };
    parameters.value = list.parameters;
  };
  useEffect(() => {
    void attempt(load);
    describe(client, component).then(
      (description) => {
        descriptions.value = new Map(description?.parameters.map((each) => [each.name, each]) ?? []);
      },
      () => {},
    );
  }, [component.address]);

  const send = async (parameter: Parameter, text: string): Promise<void> => {
    const changed = withValue(parameter, text);
    const body = encodeMessage(component.classId, types.setParam, { parameters: [changed] });
    const answer = await client.call(component.address, types.setParam, body);
    if (answer.type !== types.ok) throw new Error(new TextDecoder().decode(answer.body) || 'refused');
  };
  const set = async (parameter: Parameter, text: string) => {
    const from = valueText(parameter);
    await send(parameter, text);
    changes.value = [...changes.value, { name: parameter.name, from, to: text }];
    await load();
  };
  const undo = async () => {
    const last = changes.value.at(-1);
    const parameter = parameters.value?.find(({ name }) => name === last?.name);
    if (last === undefined || parameter === undefined) return;
    await send(parameter, last.from);
    changes.value = changes.value.slice(0, -1);
    await load();
  };

  const last = changes.value.at(-1);
  const lines = (parameters.value ?? [])
    .map((parameter): Line => ({ parameter, description: descriptions.value.get(parameter.name) }))
    .sort((a, b) => rank(a) - rank(b));
  const shown = lines
    .filter((line) => !onlyChanged.value || isChanged(line))
    .filter(({ parameter }) => parameter.name.toLowerCase().includes(filter.value.toLowerCase()));
  return (
    <div class="parameters">
      <Failure />
      {last !== undefined && (
        <p class="actions small">
          {last.name}: {last.from} → {last.to}{' '}
          <button type="button" {...needs('SET_PARAM')} onClick={() => attempt(undo)}>
            Undo
          </button>
        </p>
      )}
      {parameters.value?.length === 0 && <p class="faint">It has no parameters.</p>}
      <p class="actions">
        <input
          type="search"
          placeholder="Filter"
          aria-label="Filter parameters"
          value={filter.value}
          onInput={(event) => {
            filter.value = event.currentTarget.value;
          }}
        />
        <CheckBox checked={onlyChanged}>
          only those that differ from their default ({lines.filter(isChanged).length})
        </CheckBox>
      </p>
      <ul class="parameter-list">
        {shown.map((line) => (
          <ParameterRow
            key={`${line.parameter.name}=${valueText(line.parameter)}`}
            line={line}
            set={(text) => set(line.parameter, text)}
          />
        ))}
      </ul>
    </div>
  );
}

interface Line {
  parameter: Parameter;
  description: ParameterDescription | undefined;
}

// Has another value than its program begins with.
function isChanged({ parameter, description }: Line): boolean {
  if (description?.default === undefined) return false;
  const [now, usual] = [valueText(parameter), `${description.default}`];
  return parameter.type === 1 ? now !== usual : Number(now) !== Number(usual);
}

// Its own before those that every component has.
const rank = ({ description }: Line) => (description?.common ? 1 : 0);

interface RowProperties {
  line: Line;
  set: (text: string) => Promise<void>;
}

function ParameterRow({ line, set }: RowProperties) {
  const { parameter, description } = line;
  const { attempt, Failure } = useAttempt();
  const before = valueText(parameter);
  const change = (text: string) => text !== before && attempt(() => set(text));
  const { choices, unit, help } = description ?? {};
  const facts = factsOf(description, isChanged(line));
  const id = `facts-${parameter.name}`;
  return (
    <li class={isChanged(line) ? '' : 'unset'}>
      <span class="parameter-name">{parameter.name}</span>
      <span class="parameter-value">
        {choices === undefined ? (
          <input
            aria-label={parameter.name}
            aria-describedby={id}
            inputMode={parameter.type === 1 ? 'text' : 'decimal'}
            defaultValue={before}
            {...needs('SET_PARAM')}
            onChange={(event) => change(event.currentTarget.value)}
            onKeyDown={(event) => {
              if (event.key === 'Escape') event.currentTarget.value = before;
            }}
          />
        ) : (
          <select
            aria-label={parameter.name}
            aria-describedby={id}
            value={before}
            {...needs('SET_PARAM')}
            onChange={(event) => change(event.currentTarget.value)}
          >
            {!choices.some(({ value }) => `${value}` === before) && <option value={before}>{before}</option>}
            {choices.map(({ value, meaning }) => (
              <option key={value} value={`${value}`}>
                {value} {meaning}
              </option>
            ))}
          </select>
        )}
        {unit}
      </span>
      <div class="faint small" id={id}>
        {facts !== '' && <p>{facts}</p>}
        {help !== undefined && help !== '' && <p>{help}</p>}
      </div>
      <div>
        <Failure />
      </div>
    </li>
  );
}

// "0 to 10; default 5; at the next ON"
function factsOf(description: ParameterDescription | undefined, differs: boolean): string {
  if (description === undefined) return '';
  const { min, max, takes_effect: effect = 'now', host_file: isFile, default: usual, choices } = description;
  const isBounded = choices === undefined && min !== undefined && max !== undefined && max < unbounded;
  return [
    isBounded && min > -unbounded && `${min} to ${max}`,
    differs && usual !== '' && `default ${usual}`,
    effectWords[effect],
    isFile && 'only from its own host',
  ]
    .filter(Boolean)
    .join('; ');
}

const unbounded = 2147483647;

export function valueText({ type, valueInt, valueFloat, valueString }: Parameter): string {
  if (type === 0) return `${valueInt}`;
  if (type === 2) return `${Number(valueFloat.toPrecision(7))}`;
  return valueString;
}

function withValue(parameter: Parameter, text: string): Parameter {
  if (parameter.type === 1) return { ...parameter, valueString: text };
  const number = Number(text.replace(',', '.'));
  if (text.trim() === '' || !Number.isFinite(number)) throw new Error(`“${text}” is no number`);
  if (parameter.type === 2) return { ...parameter, valueFloat: number };
  if (!Number.isInteger(number)) throw new Error(`${parameter.name} is a whole number`);
  return { ...parameter, valueInt: number };
}
