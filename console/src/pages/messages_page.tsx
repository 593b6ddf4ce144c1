// What the components report: by level, component and text, the newest at the end.

import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { type Console, nameOf, useConsole } from '../app/console';
import { route, setOption } from '../app/route';
import { command } from '../model/commands';
import { firstErrors } from '../model/first_errors';
import { type LogText, lastOf } from '../model/log';
import type { Level } from '../tims/gdos';
import { useAttempt } from '../ui/attempt';
import { ComponentInput } from '../ui/component_input';
import { FilterBox } from '../ui/filter_box';
import { needs } from '../ui/needs';
import { saveFile } from '../ui/save';
import { timeText, UtcSwitch } from '../ui/times';

const order: Level[] = ['print', 'error', 'warning', 'info', 'detail'];
const letters: Record<Level, string> = { print: 'P', error: 'E', warning: 'W', info: 'I', detail: 'D' };
const rowsMax = 1000;

export function MessagesPage() {
  const console = useConsole();
  const { options } = route.value;
  const level = (options.get('level') as Level | null) ?? 'info';
  const filter = options.get('filter') ?? '';
  const once = options.get('once') !== null;
  const all = console.log.texts.value;
  const { shown, hidden } = once ? firstErrors(all) : { shown: all, hidden: 0 };
  const wanted = (text: LogText) => passes(console, text, level, filter);
  const texts = lastOf(shown, wanted, rowsMax);
  return (
    <section class="messages">
      <div class="tools">
        <h1>Messages</h1>
        <span class="grow" />
        <label>
          Up to{' '}
          <select value={level} onChange={(event) => setOption('level', event.currentTarget.value)}>
            {order.slice(1).map((each) => (
              <option key={each} value={each}>
                {each}
              </option>
            ))}
          </select>
        </label>
        <label title="What a component reports after an error is hidden until it is turned on or off, or begins anew">
          <input
            type="checkbox"
            checked={once}
            onChange={(event) => setOption('once', event.currentTarget.checked ? '1' : '')}
          />{' '}
          First errors only
        </label>
        <FilterBox
          label="Filter messages"
          placeholder="Component or text"
          value={filter}
          change={(text) => setOption('filter', text)}
        />
        <LevelMenu />
        <UtcSwitch />
        <button type="button" onClick={() => save(console, shown.filter(wanted))} disabled={texts.length === 0}>
          Save
        </button>
        <button type="button" onClick={() => console.log.clear()}>
          Clear
        </button>
      </div>
      {hidden > 0 && (
        <p class="small faint">
          {hidden === 1 ? 'One text after an error is' : `${hidden} texts after errors are`} hidden.
        </p>
      )}
      <LogTable texts={texts} empty={<NoTexts />} />
    </section>
  );
}

// How much a component reports: its parameter gdosLevel.
function LevelMenu() {
  const console = useConsole();
  const name = useSignal('');
  const level = useSignal<Level>('info');
  const { attempt, busy, Failure } = useAttempt();
  const report = useSignal('');
  const set = async () => {
    const component = console.fleet.robots.value
      .flatMap(({ components }) => components)
      .find(({ address }) => nameOf(console, address) === name.value.trim());
    if (component === undefined) throw new Error(`no component ${name.value} is registered`);
    const parameter = {
      name: 'gdosLevel',
      type: 0,
      valueInt: order.indexOf(level.value),
      valueFloat: 0,
      valueString: '',
    };
    await command(console.client, component, 'SET_PARAM', { parameters: [parameter] });
    report.value = `${name.value} reports up to ${level.value}.`;
  };
  return (
    <details class="menu">
      <summary>Levels</summary>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          report.value = '';
          void attempt(set);
        }}
      >
        <ComponentInput label="Level of" required value={name.value} change={(text) => (name.value = text)} />
        <select
          aria-label="Level of the component"
          value={level.value}
          onChange={(event) => (level.value = event.currentTarget.value as Level)}
        >
          {order.map((each) => (
            <option key={each}>{each}</option>
          ))}
        </select>
        <button type="submit" {...needs('SET_PARAM', { disabled: busy.value })}>
          Set
        </button>
        <span role="status">{report.value}</span>
        <Failure />
      </form>
    </details>
  );
}

function NoTexts() {
  const { fleet, log } = useConsole();
  const listens = fleet.logs.value.length > 0 || log.isSink.value;
  return (
    <p class="empty faint">
      {listens ? (
        <>
          No messages yet. New ones appear here as they arrive.
          {fleet.logs.value.length === 0 && (
            <>
              <br />
              Those from before are kept by no program: start <code>gdos-log</code> to have them next time.
            </>
          )}
        </>
      ) : (
        <>
          Another program receives the texts at this router, and it is no log: end it, or start <code>gdos-log</code>.
        </>
      )}
    </p>
  );
}

// Stays at its end unless somebody has scrolled up.
export function LogTable({ texts, empty }: { texts: LogText[]; empty: preact.ComponentChild }) {
  const console = useConsole();
  const box = useRef<HTMLDivElement>(null);
  const follows = useSignal(true);
  useEffect(() => {
    if (follows.value && box.current !== null) box.current.scrollTop = box.current.scrollHeight;
  }, [texts.at(-1)?.number, texts.at(-1)?.count]);
  if (texts.length === 0) return <>{empty}</>;
  return (
    <div
      class="log"
      ref={box}
      // biome-ignore lint/a11y/noNoninteractiveTabindex: what scrolls must be reached by keys
      tabIndex={0}
      role="log"
      aria-label="Messages of components"
      aria-live="off"
      onScroll={({ currentTarget: { scrollTop, scrollHeight, clientHeight } }) => {
        follows.value = scrollTop + clientHeight > scrollHeight - 20;
      }}
    >
      <table>
        <thead>
          <tr>
            <th scope="col">Time</th>
            <th scope="col">
              <abbr title="Level">L</abbr>
            </th>
            <th scope="col">Component</th>
            <th scope="col">Text</th>
          </tr>
        </thead>
        <tbody>
          {texts.map((text) => (
            <tr key={text.number} class={`level-${text.level}`}>
              <td class="time">{preciseText(text.time)}</td>
              <td>
                <abbr title={text.level}>{letters[text.level]}</abbr>
              </td>
              <td>{nameOf(console, text.sender)}</td>
              <td>
                {text.text}
                {text.count > 1 && <span class="count">{text.count} times</span>}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function passes(console: Console, text: LogText, level: Level, filter: string): boolean {
  if (order.indexOf(text.level) > order.indexOf(level)) return false;
  const wanted = filter.toLowerCase();
  return (
    wanted === '' ||
    text.text.toLowerCase().includes(wanted) ||
    nameOf(console, text.sender).toLowerCase().includes(wanted)
  );
}

function preciseText(time: Date): string {
  return `${timeText(time)}.${`${time.getMilliseconds()}`.padStart(3, '0')}`;
}

function save(console: Console, texts: LogText[]) {
  const lines = texts.map(
    ({ time, level, sender, text, count }) =>
      `${time.toISOString()} ${level} ${nameOf(console, sender)} ${text}${count > 1 ? ` (${count} times)` : ''}\n`,
  );
  saveFile(lines, 'text/plain', 'messages.txt');
}
