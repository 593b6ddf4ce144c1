// Every command of a class as a form, made from its description: what a class has no view for can still be sent.

import { useSignal } from '@preact/signals';
import { useConsole } from '../app/console';
import { className, decodeMessage, encodeCommand, findMessage, type Message, messagesOf } from '../codec/catalogue';
import type { Field, Fields } from '../codec/struct';
import { refusal } from '../model/commands';
import { type Component, shortName } from '../model/fleet';
import { FieldTable } from '../views/fields_view';
import { useAttempt } from './attempt';
import { needs } from './needs';
import { numberIn } from './quantities';
import { RawCommand } from './raw_command';

const commandTime = 20000; // ms; a device may take its time

interface Reply {
  text: string;
  bad: boolean;
  fields?: Field[];
  data?: Fields;
}

export function Commands({ component }: { component: Component }) {
  const { client } = useConsole();
  const commands = messagesOf(component.classId).filter(({ type }) => type > 0 && !isReply(type));
  const chosen = useSignal(0);
  const value = useSignal<Fields>({});
  const reply = useSignal<Reply | undefined>(undefined);
  const message = commands[chosen.value];
  if (message === undefined)
    return (
      <>
        <Restart component={component} />
        {className(component.classId) === undefined ? (
          <RawCommand component={component} />
        ) : (
          <p class="faint">This class has no commands of its own.</p>
        )}
      </>
    );
  const choose = (index: number) => {
    chosen.value = index;
    value.value = {};
    reply.value = undefined;
  };
  const send = async (event: Event) => {
    event.preventDefault();
    reply.value = { text: 'Sent; waiting for the answer …', bad: false };
    try {
      const body = encodeCommand(message, value.value);
      const answer = await client.call(component.address, message.type, body, commandTime);
      const why = refusal(answer);
      reply.value = why !== undefined ? { text: why, bad: true } : replyOf(component, answer);
    } catch (error) {
      reply.value = { text: (error as Error).message, bad: true };
    }
  };
  return (
    <form class="commands" onSubmit={send}>
      <Restart component={component} />
      <label>
        Command{' '}
        <select value={chosen.value} onChange={(event) => choose(Number(event.currentTarget.value))}>
          {commands.map(({ type, name }, i) => (
            <option key={type} value={i}>
              {name}
            </option>
          ))}
        </select>
      </label>
      <Inputs key={message.type} message={message} value={value.value} change={(next) => (value.value = next)} />
      <p class="actions">
        <button type="submit" class="primary" {...needs({ classId: component.classId, type: message.type })}>
          Send
        </button>
      </p>
      {reply.value !== undefined && (
        <div role={reply.value.bad ? 'alert' : 'status'} class={reply.value.bad ? 'bad' : ''}>
          <p>{reply.value.text}</p>
          {reply.value.fields !== undefined && reply.value.data !== undefined && (
            <FieldTable fields={reply.value.fields} data={reply.value.data} si={false} />
          )}
        </div>
      )}
    </form>
  );
}

function Restart({ component }: { component: Component }) {
  const { fleet } = useConsole();
  const { attempt, busy, Failure } = useAttempt();
  const isAnswering = !['silent', 'unknown'].includes(component.state.value);
  return (
    <div class="actions">
      <button
        type="button"
        aria-label={`Restart ${shortName(component)}`}
        {...needs('ON', { disabled: busy.value || !isAnswering })}
        onClick={() => attempt(() => fleet.restart(component))}
      >
        Restart
      </button>
      <span class="small faint">
        {isAnswering
          ? 'Off, and on again'
          : 'It does not answer; a program that has ended is started again by timsctl up'}
      </span>
      <Failure />
    </div>
  );
}

// Some replies of the original have positive numbers: 19 LAYER, 18 LAYER, 25 STATUS.
const firstCommand = 21;
const isReply = (type: number) => type < firstCommand;

function replyOf(
  { classId }: Component,
  { type, flags, body }: { type: number; flags: number; body: Uint8Array },
): Reply {
  const message = findMessage(classId, type);
  const text = `Answered by ${message?.name ?? `type ${type}`}.`;
  if (message?.body === undefined) return { text, bad: false };
  return { text, bad: false, fields: message.body.fields, data: decodeMessage(classId, type, body, flags) };
}

interface InputsProperties {
  message: Message;
  value: Fields;
  change: (value: Fields) => void;
}

function Inputs({ message, value, change }: InputsProperties) {
  const struct = message.body;
  if (struct === undefined) return null;
  return <FieldInputs fields={struct.fields} value={{ ...struct.made(), ...value }} change={change} />;
}

function FieldInputs({ fields, value, change }: { fields: Field[]; value: Fields; change: (value: Fields) => void }) {
  return (
    <div class="inputs">
      {fields
        .filter(({ type }) => type !== 'count')
        .map((field) => (
          <FieldInput
            key={field.name}
            field={field}
            value={value[field.name]}
            change={(next) => change({ ...value, [field.name]: next })}
          />
        ))}
    </div>
  );
}

function FieldInput({ field, value, change }: { field: Field; value: unknown; change: (value: unknown) => void }) {
  if (field.inner !== undefined && !field.isVariable && field.times === undefined)
    return (
      <fieldset>
        <legend>{field.name}</legend>
        <FieldInputs fields={field.inner.fields} value={value as Fields} change={change} />
      </fieldset>
    );
  const isText = field.type === 'text' || field.type === 'char';
  const isNumber = field.number !== undefined && !field.isVariable && field.times === undefined;
  if (isText || isNumber)
    return (
      <label>
        {field.name}
        {field.unit !== undefined && <span class="faint"> {field.unit}</span>}
        <input
          inputMode={isText ? 'text' : 'decimal'}
          defaultValue={`${value}`}
          onInput={({ currentTarget: box }) => (isText ? change(box.value) : changeNumber(box, change))}
        />
      </label>
    );
  return (
    <label>
      {field.name} <span class="faint">as JSON</span>
      <textarea
        rows={2}
        defaultValue={JSON.stringify(value)}
        onInput={(event) => change(parsed(event.currentTarget))}
      />
    </label>
  );
}

// What is no number is not sent: the form says so, and keeps the number before it.
function changeNumber(box: HTMLInputElement, change: (value: number) => void): void {
  const number = numberIn(box.value);
  box.setCustomValidity(number === undefined ? `“${box.value}” is no number` : '');
  if (number !== undefined) change(number);
}

function parsed(box: HTMLTextAreaElement): unknown {
  try {
    box.setCustomValidity('');
    return JSON.parse(box.value);
  } catch (error) {
    box.setCustomValidity((error as Error).message);
    return [];
  }
}
