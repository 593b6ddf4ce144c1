// A command to a class that is not described: its type and its bytes, as its author knows them.

import { useSignal } from '@preact/signals';
import { useConsole } from '../app/console';
import { bytesOfHex, hexDump } from '../codec/hex';
import { refusal } from '../model/commands';
import type { Component } from '../model/fleet';
import { useAttempt } from './attempt';
import { needs } from './needs';

const typeMax = 127;
const commandTime = 20_000; // ms

export function RawCommand({ component }: { component: Component }) {
  const { client } = useConsole();
  const [type, body] = [useSignal(''), useSignal('')];
  const reply = useSignal('');
  const { attempt, Failure } = useAttempt();
  const number = Number(type.value);
  const send = async () => {
    reply.value = '';
    if (type.value.trim() === '' || !Number.isInteger(number) || number < 1 || number > typeMax)
      throw new Error(`The type of a command is 1 to ${typeMax}`);
    const answer = await client.call(component.address, number, bytesOfHex(body.value), commandTime);
    const why = refusal(answer);
    if (why !== undefined) throw new Error(why);
    reply.value = `Answered by type ${answer.type}, ${answer.body.length} bytes\n${hexDump(answer.body)}`;
  };
  const submit = (event: Event) => {
    event.preventDefault();
    void attempt(send);
  };
  return (
    <form onSubmit={submit}>
      <p class="faint small">This class is not described here: a command is a number and its bytes.</p>
      <p class="actions">
        <label>
          Type{' '}
          <input
            inputMode="numeric"
            size={4}
            value={type}
            onInput={(event) => (type.value = event.currentTarget.value)}
          />
        </label>
        <label>
          Body in hex, little endian{' '}
          <input
            spellcheck={false}
            size={24}
            value={body}
            onInput={(event) => (body.value = event.currentTarget.value)}
          />
        </label>
        <button type="submit" class="primary" {...needs({ classId: component.classId, type: number })}>
          Send
        </button>
      </p>
      <Failure />
      {reply.value !== '' && (
        <pre class="hex" role="status">
          {reply.value}
        </pre>
      )}
    </form>
  );
}
