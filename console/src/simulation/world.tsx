// One simulated world: who is in it, what has touched what, and its cables.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { nameOf, useConsole } from '../app/console';
import { decodeStruct, valueName } from '../codec/catalogue';
import type { WorldData, WorldLine, WorldThing } from '../codec/messages';
import { command } from '../model/commands';
import type { Component } from '../model/fleet';
import { type Attempt, useAttempt } from '../ui/attempt';
import { needs } from '../ui/needs';
import { heading, metres } from '../ui/quantities';
import { useStream } from '../ui/use_stream';
import { StreamBox } from '../views/view';

const period = 200; // ms
const isA = (what: string) => (thing: WorldThing) => valueName('WorldThing.kind', thing.kind) === what;

export function World({ world }: { world: Component }) {
  const console = useConsole();
  const stream = useStream<WorldData>(world.address, period);
  const { attempt, Failure } = useAttempt();
  const data = stream.value.value?.data;
  const { client } = console;
  return (
    <section class="box" aria-label={nameOf(console, world.address)}>
      <h2>{nameOf(console, world.address)}</h2>
      <Failure />
      <StreamBox component={world} stream={stream}>
        {data !== undefined && (
          <>
            <p class="actions">
              <button
                type="button"
                {...needs('World.PEOPLE')}
                onClick={() =>
                  attempt(() => command(client, world, 'World.PEOPLE', { move: data.peopleMove === 0 ? 1 : 0 }))
                }
              >
                {data.peopleMove === 0 ? 'Let people walk' : 'Let people stand'}
              </button>
              <span>{data.things.filter(isA('person')).length} people</span>
              <a class="button" href={`#/map?robots=${world.system}`}>
                Place robot or obstacle on the map
              </a>
            </p>
            <Robots robots={data.things.filter(isA('robot'))} />
            <Obstacles
              obstacles={data.things.filter(isA('obstacle'))}
              remove={(id) => attempt(() => command(client, world, 'World.REMOVE', { id }))}
            />
          </>
        )}
      </StreamBox>
      <Cables world={world} attempt={attempt} />
    </section>
  );
}

function Robots({ robots }: { robots: WorldThing[] }) {
  return (
    <table class="list">
      <thead>
        <tr>
          <th scope="col">Robot</th>
          <th scope="col">North</th>
          <th scope="col">East</th>
          <th scope="col">Heading</th>
          <th scope="col">Driven</th>
          <th scope="col">Contacts with</th>
        </tr>
      </thead>
      <tbody>
        {robots.map(({ id, name, pos, travelled, isBlocked, walls, obstacles, people, robots: others, bumped }) => (
          <tr key={id} class={isBlocked === 0 ? '' : 'bad-row'}>
            <th scope="row">{name}</th>
            <td>{metres(pos.x)}</td>
            <td>{metres(pos.y)}</td>
            <td>{heading(pos.rho)}</td>
            <td>{metres(travelled)}</td>
            <td>
              {contactText({ walls, obstacles, people, robots: others })}
              {bumped > 0 && `; people walked into it ${bumped} times`}
            </td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function contactText(contacts: Record<string, number>): string {
  const texts = Object.entries(contacts).flatMap(([what, count]) => (count > 0 ? [`${count} ${what}`] : []));
  return texts.length === 0 ? 'nothing' : texts.join(', ');
}

function Obstacles({ obstacles, remove }: { obstacles: WorldThing[]; remove: (id: number) => void }) {
  if (obstacles.length === 0) return null;
  return (
    <ul class="actions">
      {obstacles.map(({ id, pos }) => (
        <li key={id}>
          Obstacle {id} at {metres(pos.x)}, {metres(pos.y)}{' '}
          <button type="button" {...needs('World.REMOVE')} onClick={() => remove(id)}>
            Remove
          </button>
        </li>
      ))}
    </ul>
  );
}

interface CablesProperties {
  world: Component;
  attempt: Attempt['attempt'];
}

// The devices of the robots: a driver sees that its cable is out.
function Cables({ world, attempt }: CablesProperties) {
  const { client } = useConsole();
  const lines = useSignal<WorldLine[]>([]);
  const load = async () => {
    const answer = await command(client, world, 'World.GET_LINES');
    lines.value = decodeStruct('WorldLines', answer.body, answer.flags).lines;
  };
  useEffect(() => void attempt(load), [world.address, world.state.value]);
  const plug = ({ robot, sensor, isPlugged }: WorldLine) =>
    attempt(async () => {
      await command(client, world, 'World.PLUG', { robot, sensor, isPlugged: isPlugged === 0 ? 1 : 0 });
      await load();
    });
  if (lines.value.length === 0) return null;
  return (
    <fieldset>
      <legend>Cables</legend>
      {lines.value.map((line) => (
        <label key={`${line.robot} ${line.sensor}`} title={line.line}>
          <input
            type="checkbox"
            checked={line.isPlugged !== 0}
            {...needs('World.PLUG')}
            onChange={() => void plug(line)}
          />{' '}
          {line.robot} {line.sensor} <span class="faint">{line.device}</span>
        </label>
      ))}
    </fieldset>
  );
}
