// How fast the console is: measured in a real browser at a real router. Prints a table.
//
//   node browser/bench.mjs [scanners] [robots] [views] [--minutes=30]
import { eventually, Host, launch, Watched } from './fixture.mjs';
import { addressOf, cameraData, ladarData, Swarm } from './swarm.mjs';

const ladar = 0x14;
const camera = 0x15;
const chassis = 0x11;
const wanted = process.argv.slice(2).filter((word) => !word.startsWith('--'));
const minutes = Number(process.argv.find((word) => word.startsWith('--minutes='))?.slice(10) ?? 30);
const benches = { scanners, robots, views };

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

async function heap(page) {
  const session = await page.context().newCDPSession(page);
  await session.send('HeapProfiler.collectGarbage');
  const { usedSize } = await session.send('Runtime.getHeapUsage');
  return usedSize / 1e6;
}

async function cpuSeconds(pid) {
  const { readFileSync } = await import('node:fs');
  const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ');
  return (Number(fields[11]) + Number(fields[12])) / 100;
}

async function scanners() {
  const host = await Host.start();
  const browser = await launch();
  const swarm = await Swarm.start(host.tcp);
  for (let i = 0; i < 20; ++i) swarm.add(addressOf(1, ladar, i), ladarData(361), 13);
  swarm.add(addressOf(1, camera, 0), cameraData(720, 486), 100);
  const tiles = [...Array.from({ length: 20 }, (_, i) => `Ladar/${i}`), 'Camera/0'].join(',');
  const watched = await Watched.open(browser, host, `#/robot/1?tiles=${tiles}`, {
    viewport: { width: 1920, height: 4000 },
  });
  const { page } = watched;
  await eventually(() => swarm.listeners === 21, 'all streams are asked for');
  await frames(page, 2000);
  const begin = {
    cpu: await cpuSeconds(host.router.pid),
    at: performance.now(),
    sent: swarm.sent,
    heap: await heap(page),
  };
  const gaps = await frames(page, 20_000);
  const seconds = (performance.now() - begin.at) / 1000;
  const cpu = (await cpuSeconds(host.router.pid)) - begin.cpu;
  console.log(
    `20 scanners of 361 points and a camera of 1 MiB, ${((swarm.sent - begin.sent) / seconds).toFixed(0)} messages/s`,
  );
  console.log(`  frames/s            ${(gaps.length / seconds).toFixed(1)}`);
  console.log(`  gap of frames, p99  ${quantile(gaps, 0.99).toFixed(1)} ms`);
  console.log(`  router              ${((100 * cpu) / seconds).toFixed(1)} % of a core`);
  console.log(`  heap                ${begin.heap.toFixed(1)} MB, then ${(await heap(page)).toFixed(1)} MB`);
  await watched.close();
  swarm.end();
  await browser.close();
  await host.end();
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
  const timed = async (what, action) => {
    const begin = performance.now();
    await action();
    console.log(`  ${what.padEnd(20)}${(performance.now() - begin).toFixed(0)} ms`);
  };
  console.log('1 000 robots of 11 components');
  await timed('sort', async () => {
    await page.getByLabel('Sort by').selectOption('number');
    await page.getByRole('link', { name: 'Robot 1', exact: true }).waitFor();
  });
  await timed('filter', async () => {
    await page.getByLabel('Filter robots').fill('777');
    await page.getByText(/^1 robot/).waitFor();
  });
  await timed('network', async () => {
    await page.goto(`${host.address}/#/network`);
    await page.getByText(/^1 router/).waitFor();
  });
  await watched.close();
  swarm.end();
  await browser.close();
  await host.end();
}

// Opens and closes views for half an hour: the heap stays flat, and no component has a listener left.
async function views() {
  const host = await Host.start();
  const browser = await launch();
  const swarm = await Swarm.start(host.tcp);
  for (let i = 0; i < 4; ++i) swarm.add(addressOf(1, ladar, i), ladarData(361), 13);
  swarm.add(addressOf(1, camera, 0), cameraData(320, 240), 100);
  const watched = await Watched.open(browser, host, '#/robot/1?tiles=');
  const { page } = watched;
  const tiles = ['Ladar/0', 'Ladar/1', 'Ladar/2', 'Ladar/3', 'Camera/0'];
  const pages = [`robot/1?tiles=${tiles.join(',')}`, 'map', 'plots?curves=Ladar(1/0).duration', 'messages', 'fleet'];
  const round = async () => {
    for (const path of pages) {
      await page.goto(`${host.address}/#/${path}`);
      await frames(page, 400);
    }
  };
  for (let i = 0; i < 5; ++i) await round();
  const begin = await heap(page);
  console.log(`views opened and closed for ${minutes} minutes`);
  let rounds = 0;
  let shownAt = performance.now();
  for (const end = performance.now() + 60_000 * minutes; performance.now() < end; ++rounds) {
    await round();
    if (performance.now() < shownAt + 60_000) continue;
    shownAt = performance.now();
    console.log(`  heap after ${rounds} rounds  ${(await heap(page)).toFixed(1)} MB`);
  }
  await page.goto(`${host.address}/#/fleet`);
  await eventually(() => swarm.listeners === 0, 'nobody listens any more');
  console.log(
    `  heap                ${begin.toFixed(1)} MB, after ${rounds} rounds ${(await heap(page)).toFixed(1)} MB`,
  );
  await watched.close();
  swarm.end();
  await browser.close();
  await host.end();
}

for (const [name, bench] of Object.entries(benches)) if (wanted.length === 0 || wanted.includes(name)) await bench();
