// Commands to components: sent by name, answered or refused with the component's own reason.

import { encodeNamed } from '../codec/catalogue';
import type { Bodies } from '../codec/messages';
import type { Answer } from '../tims/calls';
import type { Client } from '../tims/client';
import { stopPriority, types } from '../tims/header';

export type CommandName = keyof Bodies & string;

export const noPilot = 0xffffff00; // the address of none: nobody may drive a chassis

const commandTime = 5000; // ms

// Stops a robot, or takes the right to drive it: overtakes all data on the way.
export function stopCommand<Name extends CommandName>(
  client: Pick<Client, 'call'>,
  receiver: { address: number },
  name: Name,
  value?: Partial<NonNullable<Bodies[Name]>>,
): Promise<Answer> {
  return command(client, receiver, name, value, commandTime, stopPriority);
}

// Throws what hindered it, as a sentence.
export async function command<Name extends CommandName>(
  client: Pick<Client, 'call'>,
  receiver: { address: number },
  name: Name,
  value?: Partial<NonNullable<Bodies[Name]>>,
  timeout = commandTime,
  priority = 0,
): Promise<Answer> {
  const { type, body } = encodeNamed(name, value ?? {});
  const answer = await client.call(receiver.address, type, body, timeout, priority);
  const why = refusal(answer);
  if (why !== undefined) throw new Error(why);
  return answer;
}

// Undefined: it was not refused.
export function refusal({ type, body }: Answer): string | undefined {
  switch (type) {
    case types.error:
      return new TextDecoder().decode(body) || 'it refuses, without a reason';
    case types.timeout:
      return 'a component that it needs does not answer in time';
    case types.notAvailable:
      return 'it is not there';
    default:
      return undefined;
  }
}
