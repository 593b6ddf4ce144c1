// The recorders of the fleet: what each robot records, and all of them begun and ended at once.

import { nameOf, useConsole } from '../app/console';
import { classId } from '../codec/catalogue';
import type { Component } from '../model/fleet';
import { useAttempt } from '../ui/attempt';
import { Lamp } from '../ui/lamp';
import { needs } from '../ui/needs';
import { DatalogView } from '../views/datalog_view';

export function RecorderPage() {
  const console = useConsole();
  const recorders = console.fleet.robots.value.flatMap(({ components }) =>
    components.filter((component) => component.classId === classId('Datalog')),
  );
  return (
    <section>
      <div class="tools">
        <h1>Recorder</h1>
        {recorders.length > 1 && <AtOnce recorders={recorders} />}
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
          <DatalogView component={recorder} />
        </section>
      ))}
    </section>
  );
}

function AtOnce({ recorders }: { recorders: Component[] }) {
  const { fleet } = useConsole();
  const { attempt, busy, Failure } = useAttempt();
  const turn = (on: boolean) => attempt(() => Promise.all(recorders.map((recorder) => fleet.turn(recorder, on))));
  return (
    <>
      <span class="grow" />
      <button type="button" class="primary" {...needs('ON', { disabled: busy.value })} onClick={() => turn(true)}>
        Record at all
      </button>
      <button type="button" {...needs('OFF', { disabled: busy.value })} onClick={() => turn(false)}>
        Stop all
      </button>
      <Failure />
    </>
  );
}
