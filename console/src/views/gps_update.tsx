// Sets the position of a robot to that of one of its satellite receivers.

import { nameOf, useConsole } from '../app/console';
import { classId, decodeData } from '../codec/catalogue';
import type { GpsData } from '../codec/messages';
import { command } from '../model/commands';
import type { Component } from '../model/fleet';
import { types, wordBody } from '../tims/header';
import { useAttempt } from '../ui/attempt';
import { needs } from '../ui/needs';

export function GpsUpdate({ position }: { position: Component }) {
  const console = useConsole();
  const { attempt, Failure } = useAttempt();
  const receivers = console.fleet.robot(position.system)?.components.filter((each) => each.classId === classId('Gps'));
  if (receivers === undefined || receivers.length === 0) return null;
  const update = async (receiver: Component) => {
    const answer = await console.client.call(receiver.address, types.getData, wordBody(0));
    if (answer.type !== types.data) throw new Error(`${nameOf(console, receiver.address)} has no data: turn it on`);
    const {
      recordingTime,
      pos,
      var: deviation,
      mode,
    } = decodeData(receiver.classId, answer.body, answer.flags) as unknown as GpsData;
    if (mode === 0) throw new Error(`${nameOf(console, receiver.address)} does not know where it is`);
    await command(console.client, position, 'Position.UPDATE', { recordingTime, pos, var: deviation });
  };
  return (
    <p class="actions">
      {receivers.map((receiver) => (
        <button
          key={receiver.address}
          type="button"
          {...needs('Position.UPDATE')}
          onClick={() => attempt(() => update(receiver))}
        >
          It is where {nameOf(console, receiver.address)} is
        </button>
      ))}
      <Failure />
    </p>
  );
}
