// Numbers of components over time: any numeric field, as "Chassis(1/0).vx" in the address of the page.

import { useSignal } from '@preact/signals';
import { useEffect, useMemo, useRef } from 'preact/hooks';
import type uPlot from 'uplot';
import { nameOf, useConsole } from '../app/console';
import { route, setOption } from '../app/route';
import { decodeData, findMessage } from '../codec/catalogue';
import { columnsOf } from '../plots/columns';
import { KeptRings } from '../plots/kept_rings';
import { type NumberField, numberAt, numberFields } from '../plots/number_fields';
import type { Ring } from '../plots/ring';
import { decodeHeader, headerSize, types } from '../tims/header';
import { useAttempt } from '../ui/attempt';
import { fixed } from '../ui/quantities';
import { saveFile } from '../ui/save';
import { pageVisible } from '../ui/use_stream';

const period = 50; // ms
const spans: [seconds: number, text: string][] = [
  [10, '10 s'],
  [60, '1 min'],
  [300, '5 min'],
  [600, '10 min'],
];
const usualSpan = 60; // s
const ringSize = 12000; // samples: ten minutes at 20 Hz
const drawPeriod = 100; // ms
const drawsASpan = 600; // a longer span moves slower
const gapTime = 2; // s without a sample end a line
const colours = ['#2f7de1', '#e0662f', '#1f9d55', '#a24fd0', '#d19a00', '#12a0ad', '#d0407f', '#6b7a90'];

interface Curve {
  name: string; // "Chassis(1/0).vx"
  address: number;
  classId: number;
  field: NumberField;
}

const kept = new KeptRings<Curve>(ringSize, 4 * colours.length);

export function PlotsPage() {
  const chosen = (route.value.options.get('curves') ?? '').split(',').filter((name) => name !== '');
  const set = (names: string[]) => setOption('curves', names.join(','));
  const available = useAvailable();
  // That of a robot that is away is still shown.
  const curves = chosen.flatMap((name) => available.find((curve) => curve.name === name) ?? kept.curve(name) ?? []);
  const text = useSignal('');
  const { attempt, Failure } = useAttempt();
  const toggle = (name: string) =>
    set(chosen.includes(name) ? chosen.filter((each) => each !== name) : [...chosen, name]);
  const add = async () => {
    const curve = available.find(({ name }) => name.toLowerCase() === text.value.trim().toLowerCase());
    if (curve === undefined) throw new Error(`no component has a number “${text.value}”`);
    if (!chosen.includes(curve.name)) set([...chosen, curve.name]);
    text.value = '';
  };
  const submit = (event: Event) => {
    event.preventDefault();
    void attempt(add);
  };
  return (
    <section class="plots">
      <div class="tools">
        <h1>Plots</h1>
        <form onSubmit={submit} class="actions">
          <input
            list="fields"
            data-filter
            placeholder="Chassis(1/0).vx"
            aria-label="Field to plot"
            size={30}
            value={text.value}
            onInput={(event) => (text.value = event.currentTarget.value)}
          />
          <datalist id="fields">
            {available.map(({ name, field }) => (
              <option key={name} value={name}>
                {field.unit}
              </option>
            ))}
          </datalist>
          <button type="submit">Add</button>
          <Failure />
        </form>
        <ul class="actions">
          {chosen.map((name, i) => (
            <li key={name}>
              <button
                type="button"
                style={{ borderColor: colours[i % colours.length] }}
                aria-label={`Remove ${name}`}
                onClick={() => toggle(name)}
              >
                {name} ×
              </button>
            </li>
          ))}
        </ul>
      </div>
      <FieldsOf component={route.value.options.get('of') ?? ''} available={available} chosen={chosen} toggle={toggle} />
      {curves.length === 0 ? (
        <p class="empty faint">
          {chosen.length === 0
            ? 'Choose a field, for example the speed of a chassis. Up to eight curves share a plot.'
            : 'Waiting for the components of these fields …'}
        </p>
      ) : (
        <Plot key={curves.map(({ name }) => name).join()} curves={curves.slice(0, colours.length)} />
      )}
    </section>
  );
}

interface FieldsProperties {
  component: string;
  available: Curve[];
  chosen: string[];
  toggle: (name: string) => void;
}

// All fields of the component that the address names, to choose from.
function FieldsOf({ component, available, chosen, toggle }: FieldsProperties) {
  const fields = available.filter(({ name }) => name.startsWith(`${component}.`));
  if (component === '' || fields.length === 0) return null;
  return (
    <fieldset class="plot-fields">
      <legend>{component}</legend>
      {fields.map(({ name, field }) => (
        <button
          key={name}
          type="button"
          aria-pressed={chosen.includes(name)}
          aria-label={name}
          title={field.unit}
          onClick={() => toggle(name)}
        >
          {field.name}
        </button>
      ))}
    </fieldset>
  );
}

// All numeric fields of all components, in the order of the list of robots.
function useAvailable(): Curve[] {
  const console = useConsole();
  const robots = console.fleet.robots.value;
  return useMemo(
    () =>
      robots.flatMap(({ components }) =>
        components.flatMap(({ address, classId }) =>
          numberFields(findMessage(classId, types.data)?.body?.fields ?? []).map((field) => ({
            name: `${nameOf(console, address)}.${field.name}`,
            address,
            classId,
            field,
          })),
        ),
      ),
    [robots],
  );
}

function Plot({ curves }: { curves: Curve[] }) {
  const { client } = useConsole();
  const box = useRef<HTMLDivElement>(null);
  const rings = useMemo(() => curves.map((curve) => kept.of(curve)), []);
  const pausedAt = useSignal<number | undefined>(undefined); // s
  const isPaused = pausedAt.value !== undefined;
  const chosenSpan = Number(route.value.options.get('span'));
  const span = spans.some(([seconds]) => seconds === chosenSpan) ? chosenSpan : usualSpan;
  const shown = useRef<{ span: number; drawnAt: number | undefined }>({ span, drawnAt: undefined });
  const newest = useSignal<(number | undefined)[]>([]);
  const visible = pageVisible.value;
  useEffect(() => {
    if (!visible) return;
    const ends = curves.map(({ address, classId, field }, i) =>
      client.subscribe(address, period, ({ message, at }) => {
        const header = decodeHeader(message);
        if (header === undefined) return;
        const value = numberAt(decodeData(classId, message.subarray(headerSize), header.flags), field);
        if (value !== undefined) rings[i]?.add(at / 1000, value);
      }),
    );
    return () => {
      for (const end of ends) end();
    };
  }, [visible]);
  useEffect(() => {
    const element = box.current;
    if (element === null) return;
    let plot: uPlot | undefined;
    let ended = false;
    const data = () => aligned(rings, pausedAt.value ?? performance.now() / 1000, shown.current.span);
    const timer = setInterval(() => {
      if (document.hidden || plot === undefined) return;
      newest.value = rings.map((ring) => ring.newest);
      const { span, drawnAt } = shown.current;
      const now = performance.now();
      const isAsked = drawnAt === undefined; // another span was chosen, or it is paused
      if (!isAsked && (pausedAt.value !== undefined || now < drawnAt + (1000 * span) / drawsASpan)) return;
      shown.current.drawnAt = now;
      plot.setData(data());
    }, drawPeriod);
    const resize = () => plot?.setSize({ width: element.clientWidth, height: element.clientHeight - 30 });
    const observer = new ResizeObserver(resize);
    void import('uplot').then(({ default: Plotter }) => {
      if (ended) return;
      const range = (): [number, number] => [-shown.current.span, 0];
      plot = new Plotter(options(curves, element, range), data(), element);
      observer.observe(element);
    });
    return () => {
      ended = true;
      clearInterval(timer);
      observer.disconnect();
      plot?.destroy();
    };
  }, []);
  shown.current.span = span;
  useEffect(() => {
    shown.current.drawnAt = undefined; // drawn at once, also while it is paused
  }, [span, isPaused]);
  return (
    <>
      <p class="actions plot-tools">
        <button
          type="button"
          aria-pressed={isPaused}
          onClick={() => (pausedAt.value = isPaused ? undefined : performance.now() / 1000)}
        >
          {isPaused ? 'Go on' : 'Pause'}
        </button>
        <select
          aria-label="Time that is shown"
          value={span}
          onChange={(event) => setOption('span', event.currentTarget.value)}
        >
          {spans.map(([seconds, text]) => (
            <option key={seconds} value={seconds}>
              {text}
            </option>
          ))}
        </select>
        <button type="button" onClick={() => saveCsv(curves, rings)}>
          Save CSV
        </button>
        {curves.map(({ name, field }, i) => (
          <span key={name}>
            {name}: <strong>{newest.value[i]?.toPrecision(5) ?? '–'}</strong> {field.unit}
          </span>
        ))}
      </p>
      <div ref={box} class="plot" role="img" aria-label={`Plot of ${curves.map(({ name }) => name).join(', ')}`} />
    </>
  );
}

function options(curves: Curve[], element: HTMLElement, range: () => [number, number]): uPlot.Options {
  const style = getComputedStyle(element);
  const axis = { stroke: style.color, grid: { stroke: style.getPropertyValue('--line'), width: 1 } };
  return {
    width: element.clientWidth,
    height: element.clientHeight - 30,
    scales: { x: { time: false, range }, y: { range: (_, min, max) => valueRange(min, max) } },
    axes: [
      { ...axis, label: 'seconds' },
      { ...axis, size: 76, values: (_plot, splits) => stepTexts(splits) },
    ],
    series: [
      {},
      ...curves.map(({ name }, i) => ({
        label: name,
        stroke: colours[i % colours.length] ?? '',
        width: 1.5,
        points: { show: false },
      })),
    ],
  };
}

// With as many digits as tell each from the next.
function stepTexts(splits: number[]): string[] {
  const step = Math.abs((splits[1] ?? 1) - (splits[0] ?? 0)) || 1;
  const digits = Math.min(12, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)));
  return splits.map((value) => fixed(value, digits));
}

// A little more than the values; around one that stays the same, too.
function valueRange(min: number | null, max: number | null): [number, number] {
  if (min === null || max === null) return [0, 1];
  const margin = 0.1 * (max - min || Math.abs(max) || 1);
  return [min - margin, max + margin];
}

// Seconds before `now`.
function aligned(rings: Ring[], now: number, span: number): uPlot.AlignedData {
  const { times, columns } = columnsOf(rings, now - span, gapTime);
  return [times.map((time) => time - now), ...columns];
}

function saveCsv(curves: Curve[], rings: Ring[]) {
  const lines = ['curve,seconds,value\n'];
  for (const [i, ring] of rings.entries())
    ring.each((time, value) => lines.push(`${curves[i]?.name},${time.toFixed(3)},${value}\n`));
  saveFile(lines, 'text/csv', 'plot.csv');
}
