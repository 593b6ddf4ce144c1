// What the views of all classes share: their component, and whether data come.

import { computed } from '@preact/signals';
import type { ComponentChildren } from 'preact';
import { useMemo } from 'preact/hooks';
import { nameOf, useConsole } from '../app/console';
import type { Component } from '../model/fleet';
import { useAttempt } from '../ui/attempt';
import { useNow } from '../ui/connection';
import { needs } from '../ui/needs';
import { age } from '../ui/quantities';
import type { Stream } from '../ui/use_stream';

export interface ViewProperties {
  component: Component;
}

const staleTime = 2000; // ms

// Says in words why no data come; greys those that are old; says what was left out.
export function StreamBox<Data>({
  component,
  stream,
  children,
}: ViewProperties & { stream: Stream<Data>; children: ComponentChildren }) {
  const { client } = useConsole();
  const state = client.streamState(component.address).value;
  const drops = client.streamDrops(component.address).value;
  const now = useNow(500);
  // Drawn anew when one of these changes, and not for each sample.
  const isEmpty = useDerived(() => stream.value.value === undefined, [stream.value]);
  const isOld = useDerived(() => performance.now() - (stream.value.value?.at ?? 0) > staleTime, [stream.value, now]);
  const trouble = stream.trouble.value;
  if (trouble !== undefined) return <p class="bad">These data cannot be read: {trouble}</p>;
  if (isEmpty)
    return component.state.value === 'off' ? (
      <TurnOn component={component} />
    ) : (
      <p class="faint">{waitText(component, state)}</p>
    );
  return (
    <div class={isOld ? 'stale' : ''}>
      {isOld && (
        <p class="warn small" role="status">
          These data are {age((performance.now() - (stream.value.peek()?.at ?? 0)) / 1000)} old.{' '}
          {waitText(component, state)}
        </p>
      )}
      {drops !== undefined && drops.dropped >= 0.5 && !isOld && (
        <p class="warn small" role="status">
          {Math.round(drops.samples - drops.dropped)} of {Math.round(drops.samples)} Hz shown,{' '}
          {Math.round(drops.dropped)} dropped at the router: the line to it is too slow.
        </p>
      )}
      {children}
    </div>
  );
}

// A value that follows from signals.
function useDerived<Value>(derive: () => Value, inputs: unknown[]): Value {
  return useMemo(() => computed(derive), inputs).value;
}

function TurnOn({ component }: ViewProperties) {
  const console = useConsole();
  const { attempt, busy, Failure } = useAttempt();
  const name = nameOf(console, component.address);
  return (
    <div class="turn-on">
      <p class="faint">{name} is off.</p>
      <button
        type="button"
        aria-label={`Turn on ${name}`}
        {...needs('ON', { disabled: busy.value })}
        onClick={() => void attempt(() => console.fleet.turn(component, true))}
      >
        Turn on
      </button>
      <Failure />
    </div>
  );
}

function waitText(component: Component, state: string | undefined): string {
  if (state === 'gone' || component.state.value === 'silent') return 'It does not answer.';
  if (component.state.value === 'off') return 'It is off.';
  if (component.state.value === 'error')
    return `It is in error: ${sentence(component.why.value || 'the messages say why')}`;
  if (state === 'refused') return 'It refuses to send its data; asking again.';
  return 'Waiting for data …';
}

const sentence = (text: string) => (/[.?!]$/.test(text) ? text : `${text}.`);
