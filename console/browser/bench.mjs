// How fast the console is: measured in a real browser at a real router, beside what it must reach. Prints a table; the
// exit status is 1 when something was not reached.
//
//   node browser/bench.mjs [page] [scanners] [robots] [views] [--minutes=30] [--seconds=20]
//
// On a machine that does nothing else: what is measured are times of two programs that share its processors.
import { readdirSync, readFileSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { BarePage } from './bare_page.mjs';
import { eventually, Host, launch, programs, Watched } from './fixture.mjs';
import { RouterTree } from './router_tree.mjs';
import { addressOf, cameraData, ladarData, Swarm } from './swarm.mjs';

const ladar = 0x14;
const camera = 0x15;
const chassis = 0x11;
const option = (name, usual) =>
  Number(process.argv.find((word) => word.startsWith(`--${name}=`))?.split('=')[1] ?? usual);
const wanted = process.argv.slice(2).filter((word) => !word.startsWith('--'));
const minutes = option('minutes', 30);
const seconds = option('seconds', 20);
const benches = { page, scanners, robots, views };

let missed = 0;

const shown = (value) => (Number.isInteger(value) ? `${value}` : value.toFixed(1));

// A row of the table. `limit`: [atLeast, atMost], of which one is undefined; none: it is only told.
function row(what, value, unit, [atLeast, atMost] = []) {
  const isMet = (atLeast === undefined || value >= atLeast) && (atMost === undefined || value <= atMost);
  const isRated = atLeast !== undefined || atMost !== undefined;
  if (!isMet) ++missed;
  const limit = atLeast !== undefined ? `at least ${atLeast}` : atMost !== undefined ? `at most ${atMost}` : '';
  const verdict = !isRated ? '' : isMet ? 'reached' : 'MISSED';
  console.log(`  ${what.padEnd(36)}${`${shown(value)} ${unit}`.padStart(14)}  ${limit.padEnd(16)}${verdict}`);
}
const atLeast = (value) => [value, undefined];
const atMost = (value) => [undefined, value];

// Gaps between frames while `time` ms pass.
const frames = (page, time) =>
  page.evaluate(
    (duration) =>
      new Promise((resolve) => {
        const gaps = [];
        let last = performance.now();
        const end = last + duration;
        const frame = (now) => {
          gaps.push(now - last);
          last = now;
          if (now < end) requestAnimationFrame(frame);
          else resolve(gaps);
        };
        requestAnimationFrame(frame);
      }),
    time,
  );

const quantile = (values, part) => [...values].sort((a, b) => a - b)[Math.floor(part * (values.length - 1))];

// `session`: of DevTools, with the page.
async function heap(session) {
  await session.send('HeapProfiler.collectGarbage');
  const { usedSize } = await session.send('Runtime.getHeapUsage');
  return usedSize / 1e6;
}

function cpuSeconds(pid) {
  const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ');
  return (Number(fields[11]) + Number(fields[12])) / 100;
}

// --- the first page

async function page() {
  console.log('the first page');
  const folder = process.env.TIMS_CONSOLE ?? join(programs, '../share/tims/console');
  const scripts = readdirSync(folder).filter((name) => name.endsWith('.js.br'));
  const sizes = new Map(scripts.map((name) => [name.slice(0, -'.br'.length), statSync(join(folder, name)).size]));
  const host = await Host.start();
  const browser = await launch();
  const loaded = new Set();
  const paints = [];
  for (let i = 0; i < 5; ++i) {
    const watched = await Watched.open(browser, host, '#/fleet');
    watched.page.on('request', (request) => loaded.add(new URL(request.url()).pathname.slice(1)));
    if (i === 0) await watched.page.reload(); // as a new visitor: the cache of a page is that of its context
    await watched.page.getByText('No robot is here yet').waitFor();
    const paint = () => performance.getEntriesByName('first-contentful-paint')[0]?.startTime;
    paints.push(await eventually(() => watched.page.evaluate(paint), 'something is painted'));
    await watched.close();
  }
  const kilobytes = (names) => names.reduce((sum, name) => sum + (sizes.get(name) ?? 0), 0) / 1000;
  row('its scripts, brotli', kilobytes([...loaded]), 'kB', atMost(60));
  row('all scripts, brotli', kilobytes([...sizes.keys()]), 'kB', atMost(250));
  row('first paint, median of 5', quantile(paints, 0.5), 'ms', atMost(1000));
  await browser.close();
  await host.end();
}

// --- 20 scanners and a camera

const echo = 'Test(9/0)';

// A router with a component that answers.
async function hostWithEcho() {
  const host = await Host.start();
  host.run('tims-demo', ['server', '--at', echo]);
  await eventually(() => host.timsctl('ping', echo, '-n', '1'), 'the component answers');
  return host;
}

// The round trip of another client of the router, by TCP and thus through its loop, in µs.
async function roundTrip(host) {
  const { items } = await host.timsctl('-H', `127.0.0.1:${host.tcp}`, 'ping', echo, '-n', '1000', '--interval', '10ms');
  return (
    1e6 *
    quantile(
      items.flatMap(({ rtt_s }) => rtt_s ?? []),
      0.5,
    )
  );
}

// A screen of 1920 × 1080 at a zoom of 50 %, where all tiles are in sight. The browser draws by the processor here, so that
// its time goes by the number of pixels.
const allOnOneScreen = { width: 3840, height: 2160, deviceScaleFactor: 0.5, mobile: false };

// Within a page: how many views have it.
function chooseFullRate() {
  const boxes = [...document.querySelectorAll('label')].filter((label) => label.textContent.includes('full rate'));
  for (const label of boxes) if (!label.querySelector('input').checked) label.querySelector('input').click();
  return boxes.length;
}

// Within a page: of the scans that have come since it was opened.
function partDrawn() {
  const counts = [...document.body.textContent.matchAll(/(\d+) of (\d+) scans were not drawn/g)];
  const sum = (group) => counts.reduce((total, match) => total + Number(match[group]), 0);
  return 1 - sum(1) / sum(2);
}

// What the console costs others of its router is measured beside a router of nobody at the same time: the browser
// takes the processors from both alike.
async function scanners() {
  const host = await hostWithEcho();
  const other = await hostWithEcho();
  const browser = await launch();
  const swarm = await Swarm.start(host.tcp);
  for (let i = 0; i < 20; ++i) swarm.add(addressOf(1, ladar, i), ladarData(361), 13);
  swarm.add(addressOf(1, camera, 0), cameraData(720, 486), 100);
  const tiles = [...Array.from({ length: 20 }, (_, i) => `Ladar/${i}`), 'Camera/0'].join(',');
  const page = await BarePage.open(browser, `${host.address}/#/robot/1?tiles=${tiles}`, { width: 1920, height: 1080 });
  await page.send('Emulation.setDeviceMetricsOverride', allOnOneScreen);
  await eventually(() => swarm.listeners === 21, 'all streams are asked for');
  await eventually(async () => (await page.evaluate(chooseFullRate)) === 20, 'all scanners are asked for each scan');
  await frames(page, 2000);
  const begin = { cpu: cpuSeconds(host.router.pid), at: performance.now(), sent: swarm.sent, heap: await heap(page) };
  const gaps = await frames(page, 1000 * seconds);
  const time = (performance.now() - begin.at) / 1000;
  const cpu = cpuSeconds(host.router.pid) - begin.cpu;
  const sent = (swarm.sent - begin.sent) / time;
  const growth = (await heap(page)) - begin.heap;
  const drawn = (await page.evaluate(partDrawn)) * ((sent - 10) / 20);
  const [beside, without] = await Promise.all([roundTrip(host), roundTrip(other)]);
  console.log(`20 scanners of 361 points and a camera of 1 MiB, for ${seconds} s`);
  row('messages', sent, '/s', atLeast(1400));
  row('frames', (1000 * gaps.length) / gaps.reduce((sum, gap) => sum + gap, 0), '/s', atLeast(55));
  row('gap of frames, p99', quantile(gaps, 0.99), 'ms', atMost(33));
  row('frames that came late', (100 * gaps.filter((gap) => gap > 25).length) / gaps.length, '%');
  row('scans drawn, of a scanner', drawn, '/s');
  row('router, of a core', (100 * cpu) / time, '%', atMost(15));
  row('growth of the heap', growth, 'MB', atMost(5));
  row('round trip of others, median', beside, 'µs');
  row('the same at a router of nobody', without, 'µs');
  row('ratio of the two', beside / without, '', atMost(1.2));
  await page.close();
  swarm.end();
  await browser.close();
  await host.end();
  await other.end();
}

// --- 1 000 robots

// From an input to the end of the frame that shows its result, as the page itself sees it: the median of five, without
// the time that the tool needs which asks.
async function timeOf(page, first, second) {
  const times = [];
  for (let i = 0; i < 6; ++i) {
    const time = await page.evaluate(
      ({ selector, value, event, expected }) =>
        new Promise((resolve, reject) => {
          const input = document.querySelector(selector);
          const begin = performance.now();
          const look = () => {
            if (document.querySelector('main').textContent.includes(expected))
              return resolve(performance.now() - begin);
            if (performance.now() > begin + 5000) return reject(new Error(`never shown: ${expected}`));
            requestAnimationFrame(() => setTimeout(look));
          };
          Object.getOwnPropertyDescriptor(Object.getPrototypeOf(input), 'value').set.call(input, value);
          input.dispatchEvent(new Event(event, { bubbles: true }));
          requestAnimationFrame(() => setTimeout(look));
        }),
      i % 2 === 0 ? first : second,
    );
    if (i % 2 === 0) times.push(time);
  }
  return quantile(times, 0.5);
}

async function robots() {
  const host = await Host.start(['address.widths="16/8/4/4"', 'limits.mailboxes_per_client=20000']);
  const browser = await launch();
  const swarm = await Swarm.start(host.tcp);
  for (let system = 1; system <= 1000; ++system)
    for (let instance = 0; instance < 11; ++instance)
      swarm.add(((system << 16) | (chassis << 8) | (instance << 4)) >>> 0);
  const watched = await Watched.open(browser, host);
  const { page } = watched;
  await page.getByText('1000 robots').waitFor();
  await page.getByRole('link', { name: 'Robot 1', exact: true }).waitFor();
  console.log('1 000 robots of 11 components');
  const list = () =>
    page.evaluate(
      () =>
        new Promise((resolve) => {
          location.hash = '#/messages';
          setTimeout(() => {
            const begin = performance.now();
            location.hash = '#/fleet';
            const look = () =>
              document.querySelectorAll('.robots > li').length >= 60
                ? resolve(performance.now() - begin)
                : requestAnimationFrame(() => setTimeout(look));
            requestAnimationFrame(() => setTimeout(look));
          }, 500);
        }),
    );
  const lists = [];
  for (let i = 0; i < 3; ++i) lists.push(await list());
  row('list', quantile(lists, 0.5), 'ms', atMost(100));
  const sort = { selector: '.tools select', event: 'change' };
  const filter = { selector: '[data-filter]', event: 'input' };
  row(
    'sort',
    await timeOf(page, { ...sort, value: 'number', expected: 'Robot 1' }, { ...sort, value: 'trouble', expected: '' }),
    'ms',
    atMost(100),
  );
  row(
    'filter',
    await timeOf(
      page,
      { ...filter, value: '777', expected: 'Robot 777' },
      { ...filter, value: '', expected: '1000 robots' },
    ),
    'ms',
    atMost(100),
  );
  row('streams that are asked for', swarm.listeners, '', atMost(0));
  await watched.close();
  swarm.end();
  const tree = await RouterTree.start(1000, host.http);
  const network = await Watched.open(browser, tree, '#/messages');
  await network.page.getByRole('heading', { name: 'Messages' }).waitFor();
  const time = await network.page.evaluate(
    () =>
      new Promise((resolve) => {
        const begin = performance.now();
        location.hash = '#/network';
        const look = () =>
          document.querySelector('main').textContent.includes('1001 routers')
            ? resolve(performance.now() - begin)
            : requestAnimationFrame(() => setTimeout(look));
        look();
      }),
  );
  row('topology, 1 001 routers that answer', time, 'ms', atMost(500));
  await network.close();
  tree.end();
  await browser.close();
  await host.end();
}

// --- half an hour

// Opens and closes views: the heap stays flat, and no component has a listener left.
async function views() {
  const host = await Host.start();
  const browser = await launch();
  const swarm = await Swarm.start(host.tcp);
  for (let i = 0; i < 4; ++i) swarm.add(addressOf(1, ladar, i), ladarData(361), 13);
  swarm.add(addressOf(1, camera, 0), cameraData(320, 240), 100);
  const watched = await Watched.open(browser, host, '#/robot/1?tiles=');
  const { page } = watched;
  const session = await watched.context.newCDPSession(page);
  const tiles = ['Ladar/0', 'Ladar/1', 'Ladar/2', 'Ladar/3', 'Camera/0'];
  const pages = [`robot/1?tiles=${tiles.join(',')}`, 'map', 'plots?curves=Ladar(1/0).duration', 'messages', 'fleet'];
  const round = async () => {
    for (const path of pages) {
      await page.goto(`${host.address}/#/${path}`);
      await frames(page, 400);
    }
  };
  for (let i = 0; i < 5; ++i) await round();
  const begin = await heap(session);
  console.log(`views opened and closed for ${minutes} minutes`);
  let rounds = 0;
  let shownAt = performance.now();
  for (const end = performance.now() + 60_000 * minutes; performance.now() < end; ++rounds) {
    await round();
    if (performance.now() < shownAt + 60_000) continue;
    shownAt = performance.now();
    row(`heap after ${rounds} rounds`, await heap(session), 'MB');
  }
  await page.goto(`${host.address}/#/fleet`);
  swarm.forgetWhoIsGone();
  await eventually(() => swarm.listeners === 0, 'nobody listens any more').catch(() => {});
  row('rounds', rounds, '');
  row('heap at the beginning', begin, 'MB');
  row('growth of the heap', (await heap(session)) - begin, 'MB', atMost(2));
  row('listeners left at components', swarm.listeners, '', atMost(0));
  await watched.close();
  swarm.end();
  await browser.close();
  await host.end();
}

for (const [name, bench] of Object.entries(benches)) if (wanted.length === 0 || wanted.includes(name)) await bench();
if (missed > 0) console.log(`${missed} not reached`);
process.exitCode = missed > 0 ? 1 : 0;
