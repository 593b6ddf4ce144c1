// The recorder of a robot: which streams it stores, how often, in which files, and how much it has stored.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { nameOf, useConsole } from '../app/console';
import { decodeStruct } from '../codec/catalogue';
import type { DatalogData, DatalogLogInfo } from '../codec/messages';
import { command } from '../model/commands';
import { useAttempt } from '../ui/attempt';
import { needs } from '../ui/needs';
import { bytes } from '../ui/quantities';
import { useVisible } from '../ui/use_stream';
import type { ViewProperties } from './view';

const period = 1000; // ms

export function DatalogView({ component }: ViewProperties) {
  const console = useConsole();
  const { client } = console;
  const status = useSignal<DatalogData | undefined>(undefined);
  const wanted = useSignal<DatalogData | undefined>(undefined); // as edited
  const { attempt, Failure } = useAttempt();
  const isOn = component.state.value === 'on';
  const load = async () => {
    const answer = await command(client, component, 'Datalog.GET_LOG_STATUS');
    status.value = decodeStruct('DatalogData', answer.body, answer.flags);
  };
  const visible = useVisible();
  useEffect(() => {
    if (!visible) return;
    void attempt(load);
    const timer = setInterval(() => attempt(load), period);
    return () => clearInterval(timer);
  }, [component.address, visible]);
  const shown = wanted.value ?? status.value;
  const edit = (number: number, part: Partial<DatalogLogInfo>) => {
    if (shown === undefined) return;
    wanted.value = { ...shown, logInfo: shown.logInfo.map((info, i) => (i === number ? { ...info, ...part } : info)) };
  };
  const record = async () => {
    if (wanted.value !== undefined) await command(client, component, 'Datalog.SET_LOG', wanted.value);
    wanted.value = undefined;
    await console.fleet.turn(component, true);
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
            <button type="button" class="primary" {...needs('ON')} onClick={() => attempt(record)}>
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
            {...needs('Datalog.SET_LOG', { disabled: isOn })}
            value={shown?.logPathName ?? ''}
            onInput={(event) => {
              if (shown !== undefined) wanted.value = { ...shown, logPathName: event.currentTarget.value };
            }}
          />
        </label>
      </p>
      <Failure />
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
                <th scope="row">{name}</th>
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
                <td>{info.filename}</td>
                <td>{now !== undefined && now.setsLogged > 0 && `${now.setsLogged} (${bytes(now.bytesLogged)})`}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </>
  );
}
