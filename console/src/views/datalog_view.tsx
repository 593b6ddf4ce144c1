// The recorder of a robot: which streams it stores, how often, in which files, and how much it has stored.

import { type Signal, useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { type Console, nameOf, useConsole } from '../app/console';
import { decodeStruct } from '../codec/catalogue';
import type { DatalogData, DatalogLogInfo } from '../codec/messages';
import { command } from '../model/commands';
import type { Component } from '../model/fleet';
import { useAttempt } from '../ui/attempt';
import { Lamp } from '../ui/lamp';
import { needs } from '../ui/needs';
import { bytes } from '../ui/quantities';
import { useVisible } from '../ui/use_stream';
import type { ViewProperties } from './view';

const period = 1000; // ms
const silentTime = 5000; // ms without a sample, while it records
const fileNameMax = 39; // characters

// What somebody has edited and not sent; undefined: nothing.
export type Wanted = Signal<DatalogData | undefined>;

// Sends what was edited, and begins.
export async function record({ client, fleet }: Console, recorder: Component, wanted: Wanted): Promise<void> {
  if (wanted.value !== undefined) await command(client, recorder, 'Datalog.SET_LOG', wanted.value);
  wanted.value = undefined;
  await fleet.turn(recorder, true);
}

// `edited`: for a page that begins the recording, too.
export function DatalogView({ component, edited }: ViewProperties & { edited?: Wanted }) {
  const console = useConsole();
  const { client } = console;
  const status = useSignal<DatalogData | undefined>(undefined);
  const own = useSignal<DatalogData | undefined>(undefined);
  const wanted = edited ?? own;
  const { attempt, Failure } = useAttempt();
  const polling = useAttempt(); // its success takes no refusal of a command away
  const lampOf = useLamps();
  const isOn = component.state.value === 'on';
  const load = async () => {
    const answer = await command(client, component, 'Datalog.GET_LOG_STATUS');
    status.value = decodeStruct('DatalogData', answer.body, answer.flags);
  };
  const visible = useVisible();
  useEffect(() => {
    if (!visible) return;
    void polling.attempt(load);
    const timer = setInterval(() => polling.attempt(load), period);
    return () => clearInterval(timer);
  }, [component.address, visible]);
  const shown = wanted.value ?? status.value;
  const edit = (number: number, part: Partial<DatalogLogInfo>) => {
    if (shown === undefined) return;
    wanted.value = { ...shown, logInfo: shown.logInfo.map((info, i) => (i === number ? { ...info, ...part } : info)) };
  };
  const list = async () => {
    await command(client, component, 'Datalog.INIT_LOG');
    wanted.value = undefined;
    await load();
  };
  return (
    <>
      <p class="actions">
        {isOn ? (
          <button type="button" {...needs('OFF')} onClick={() => attempt(() => console.fleet.turn(component, false))}>
            Stop recording
          </button>
        ) : (
          <>
            <button
              type="button"
              class="primary"
              {...needs('ON')}
              onClick={() => attempt(() => record(console, component, wanted))}
            >
              Record
            </button>
            <button type="button" {...needs('Datalog.INIT_LOG')} onClick={() => attempt(list)}>
              List the streams anew
            </button>
          </>
        )}
        <label>
          Folder{' '}
          <input
            {...needs('Datalog.SET_LOG', { disabled: isOn || shown === undefined })}
            value={shown?.logPathName ?? ''}
            onInput={(event) => {
              if (shown !== undefined) wanted.value = { ...shown, logPathName: event.currentTarget.value };
            }}
          />
        </label>
      </p>
      <Failure />
      <polling.Failure />
      {shown !== undefined && shown.logInfo.length === 0 && <p class="faint">It has found no streams.</p>}
      <table class="list">
        <thead>
          <tr>
            <th scope="col">Stream</th>
            <th scope="col">Record</th>
            <th scope="col">
              <abbr title="in ms; 0: every sample">Period</abbr>
            </th>
            <th scope="col">File</th>
            <th scope="col">Stored</th>
          </tr>
        </thead>
        <tbody>
          {shown?.logInfo.map((info, i) => {
            const name = nameOf(console, info.moduleMbx);
            const now = status.value?.logInfo[i];
            return (
              <tr key={info.moduleMbx}>
                <th scope="row">
                  <Lamp state={lampOf(info, now, isOn)} /> {name}
                </th>
                <td>
                  <input
                    type="checkbox"
                    aria-label={`Record ${name}`}
                    {...needs('Datalog.SET_LOG', { disabled: isOn })}
                    checked={info.logEnable !== 0}
                    onChange={(event) => edit(i, { logEnable: event.currentTarget.checked ? 1 : 0 })}
                  />
                </td>
                <td>
                  <input
                    inputMode="numeric"
                    size={5}
                    aria-label={`Period of ${name} in ms`}
                    {...needs('Datalog.SET_LOG', { disabled: isOn })}
                    key={info.periodTime}
                    defaultValue={`${info.periodTime}`}
                    onChange={(event) =>
                      edit(i, { periodTime: Math.max(0, Math.round(Number(event.currentTarget.value)) || 0) })
                    }
                  />
                </td>
                <td>
                  <input
                    size={20}
                    maxLength={fileNameMax}
                    aria-label={`File of ${name}`}
                    {...needs('Datalog.SET_LOG', { disabled: isOn })}
                    key={info.filename}
                    defaultValue={info.filename}
                    onChange={(event) => edit(i, { filename: event.currentTarget.value.trim() || info.filename })}
                  />
                </td>
                <td>{now !== undefined && now.setsLogged > 0 && `${now.setsLogged} (${bytes(now.bytesLogged)})`}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </>
  );
}

// On: samples come; silent: none comes though it shall be recorded.
function useLamps() {
  const grown = useRef(new Map<number, { sets: number; at: number }>());
  return (
    { moduleMbx, logEnable }: DatalogLogInfo,
    now: DatalogLogInfo | undefined,
    isOn: boolean,
  ): 'on' | 'off' | 'silent' => {
    if (!isOn || logEnable === 0 || now === undefined) {
      grown.current.delete(moduleMbx);
      return 'off';
    }
    const before = grown.current.get(moduleMbx);
    if (before === undefined || before.sets !== now.setsLogged)
      grown.current.set(moduleMbx, { sets: now.setsLogged, at: performance.now() });
    const last = grown.current.get(moduleMbx)?.at ?? 0;
    return performance.now() - last < Math.max(silentTime, 3 * now.periodTime) ? 'on' : 'silent';
  };
}
