// The recorders of the fleet: what each robot records, and all of them begun and ended at once.

import { signal } from '@preact/signals';
import { useMemo } from 'preact/hooks';
import { nameOf, useConsole } from '../app/console';
import { classId } from '../codec/catalogue';
import type { DatalogData } from '../codec/messages';
import type { Component } from '../model/fleet';
import { useAttempt } from '../ui/attempt';
import { Lamp } from '../ui/lamp';
import { needs } from '../ui/needs';
import { DatalogView, record, type Wanted } from '../views/datalog_view';

export function RecorderPage() {
  const console = useConsole();
  const recorders = console.fleet.robots.value.flatMap(({ components }) =>
    components.filter((component) => component.classId === classId('Datalog')),
  );
  const edits = useMemo(() => new Map<number, Wanted>(), []);
  const editedOf = ({ address }: Component): Wanted => {
    const edited = edits.get(address) ?? signal<DatalogData | undefined>(undefined);
    edits.set(address, edited);
    return edited;
  };
  return (
    <section>
      <div class="tools">
        <h1>Recorder</h1>
        {recorders.length > 1 && <AtOnce recorders={recorders} editedOf={editedOf} />}
      </div>
      {recorders.length === 0 && (
        <p class="empty faint">
          No recorder has registered. A robot gets one by <code>program = "DatalogRec"</code> in its file.
        </p>
      )}
      {recorders.map((recorder) => (
        <section key={recorder.address} class="box" aria-label={nameOf(console, recorder.address)}>
          <h2>
            <Lamp state={recorder.state.value} /> <a href={`#/robot/${recorder.system}`}>Robot {recorder.system}</a>,{' '}
            {nameOf(console, recorder.address)}
          </h2>
          <DatalogView component={recorder} edited={editedOf(recorder)} />
        </section>
      ))}
    </section>
  );
}

interface AtOnceProperties {
  recorders: Component[];
  editedOf: (recorder: Component) => Wanted;
}

function AtOnce({ recorders, editedOf }: AtOnceProperties) {
  const console = useConsole();
  const { attempt, busy, Failure } = useAttempt();
  const stopped = () => recorders.filter(({ state }) => state.value !== 'on');
  const begin = () => Promise.all(stopped().map((recorder) => record(console, recorder, editedOf(recorder))));
  const end = () => Promise.all(recorders.map((recorder) => console.fleet.turn(recorder, false)));
  return (
    <>
      <span class="grow" />
      <button type="button" class="primary" {...needs('ON', { disabled: busy.value })} onClick={() => attempt(begin)}>
        Record at all
      </button>
      <button type="button" {...needs('OFF', { disabled: busy.value })} onClick={() => attempt(end)}>
        Stop all
      </button>
      <Failure />
    </>
  );
}
