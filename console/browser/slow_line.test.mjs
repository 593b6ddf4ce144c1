// A robot behind a bad line: 1 MB/s, 100 ms, 2 % loss in both directions, with more data than fit.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { ageShown, clockScan, median, sorted } from './clock_scan.mjs';
import { eventually, launch, startFleet, Watched } from './fixture.mjs';
import { addressOf, cameraData, Swarm } from './swarm.mjs';

const classes = { chassis: 0x11, ladar: 0x14, camera: 0x15, pilot: 0x18 };
const line = { rate: 1_000_000, delay_s: 0.05, loss: 0.02 };
const ageMax = 500; // ms
const stopMax = 300;

let base;
let robot;
let browser;
let swarm;

before(async () => {
  [base, robot] = await startFleet(1);
  browser = await launch();
  swarm = await Swarm.start(robot.tcp);
  for (let i = 0; i < 4; ++i) swarm.add(addressOf(1, classes.ladar, i), clockScan(), 13);
  swarm.add(addressOf(1, classes.camera, 0), cameraData(640, 480), 100);
  swarm.add(addressOf(1, classes.chassis, 0), undefined, undefined, {});
  swarm.add(addressOf(1, classes.pilot, 0), undefined, undefined, {});
  for (const host of [base, robot]) await host.ask({ ask: 'fault', ...line });
});

after(async () => {
  swarm?.end();
  await browser?.close();
  for (const host of [robot, base]) await host?.end();
});

afterEach(Watched.closeAll);

test('the newest scan is young and STOP is fast, with a camera on the same line', async () => {
  const tiles = ['Ladar/0', 'Ladar/1', 'Ladar/2', 'Ladar/3', 'Camera/0'];
  const watched = await Watched.open(browser, base, `#/robot/1?tiles=${tiles.join(',')}`, {
    viewport: { width: 1920, height: 1800 },
  });
  const { page } = watched;
  const tile = page.getByRole('region', { name: 'Ladar/0' });
  await tile.getByText(/points; the nearest/).waitFor();
  await page.getByRole('region', { name: 'Camera/0' }).getByText('640 × 480, rgb24').waitFor();
  await page.evaluate(() => {
    const press = (event) => {
      globalThis.pressedAt = performance.timeOrigin + event.timeStamp;
    };
    addEventListener('pointerdown', press, { capture: true });
  });
  const ages = [];
  const times = [];
  for (let i = 0; i < 6; ++i) {
    await page.waitForTimeout(200);
    for (let k = 0; k < 5; ++k) ages.push(await ageShown(tile));
    const chassis = swarm.components.get(addressOf(1, classes.chassis, 0));
    chassis.commands.length = 0;
    await page.getByRole('button', { name: 'Stop robot 1' }).click();
    await eventually(() => chassis.commands.length > 0, 'STOP has arrived', 5000);
    // From the press of the button, as the browser got it from the mouse, to the chassis: the clocks are one.
    times.push(chassis.commands[0].at - (await page.evaluate(() => globalThis.pressedAt)));
    assert(chassis.commands[0].priority >= 100, 'it overtakes what else is on the line');
  }
  console.log(`ages of scans ${sorted(ages)} ms; STOP ${sorted(times)} ms`);
  assert(median(ages) < ageMax, `ages: ${sorted(ages)}`);
  assert(median(times) < stopMax, `STOP: ${sorted(times)}`);
  const other = await base.timsctl('component', 'list');
  assert(other.items.length > 0, 'other clients are served');
  await watched.close();
});
