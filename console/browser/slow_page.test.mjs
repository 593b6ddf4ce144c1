// A page whose own connection takes less than its robot sends: eight scanners, shown ten times a second, 460 kB/s, over 150 kB/s.
import assert from 'node:assert/strict';
import { connect, createServer } from 'node:net';
import { after, afterEach, before, test } from 'node:test';
import { ageShown, clockScan, median, sorted } from './clock_scan.mjs';
import { eventually, launch, startFleet, Watched } from './fixture.mjs';
import { addressOf, Swarm } from './swarm.mjs';

const classes = { chassis: 0x11, ladar: 0x14, pilot: 0x18 };
const bytesPerMs = 150;
const scanners = [0, 1, 2, 3, 4, 5, 6, 7];
const ageMax = 4500; // ms; what waits in the sockets of both sides takes about 2500
const stopMax = 300;
const watchedFor = 12_000; // ms: if all samples were sent, they would be 8000 late by then

let base;
let robot;
let browser;
let swarm;
let line;

// What one side sends is passed on at this rate, and not read faster.
function passSlowly(from, to) {
  let freeAt = performance.now();
  from.on('data', (bytes) => {
    from.pause();
    to.write(bytes);
    freeAt = Math.max(freeAt, performance.now()) + bytes.length / bytesPerMs;
    setTimeout(() => from.resume(), freeAt - performance.now());
  });
}

// A port that passes on to another one; what comes back is slow.
function slowLineTo(port) {
  const server = createServer((page) => {
    const router = connect(port, '127.0.0.1');
    page.pipe(router);
    passSlowly(router, page);
    for (const [one, other] of [
      [page, router],
      [router, page],
    ]) {
      one.on('error', () => other.destroy());
      one.on('close', () => other.destroy());
    }
  });
  return new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(server)));
}

before(async () => {
  [base, robot] = await startFleet(1);
  browser = await launch();
  swarm = await Swarm.start(robot.tcp);
  for (const i of scanners) swarm.add(addressOf(1, classes.ladar, i), clockScan(), 13);
  swarm.add(addressOf(1, classes.chassis, 0), undefined, undefined, {});
  swarm.add(addressOf(1, classes.pilot, 0), undefined, undefined, {});
  line = await slowLineTo(base.http);
});

after(async () => {
  swarm?.end();
  await browser?.close();
  line?.close();
  for (const host of [robot, base]) await host?.end();
});

afterEach(Watched.closeAll);

test('shows the newest scans, not all of them, and STOP is fast', async () => {
  const tiles = scanners.map((i) => `Ladar/${i}`);
  const address = `http://127.0.0.1:${line.address().port}`;
  const watched = await Watched.open(browser, { address }, `#/robot/1?tiles=${tiles.join(',')}`);
  const { page } = watched;
  const tile = page.getByRole('region', { name: 'Ladar/0' });
  await tile.getByText(/points; the nearest/).waitFor();
  await page.waitForTimeout(watchedFor);
  const ages = [];
  for (let i = 0; i < 20; ++i) {
    ages.push(await ageShown(tile));
    await page.waitForTimeout(50);
  }
  console.log(`ages of scans ${sorted(ages)} ms`);
  assert(median(ages) < ageMax, `ages: ${sorted(ages)}`);
  const chassis = swarm.components.get(addressOf(1, classes.chassis, 0));
  const pressedAt = Date.now();
  await page.getByRole('button', { name: 'Stop robot 1' }).click();
  await eventually(() => chassis.commands.length > 0, 'STOP has arrived', 5000);
  assert(chassis.commands[0].at - pressedAt < stopMax, `STOP: ${chassis.commands[0].at - pressedAt} ms`);
  await watched.close();
});
