// The pictures of the README: node browser/pictures.mjs [FOLDER]. A robot that drives to a goal in a room of the map, and the
// network of a fleet whose link has been cut.
import { fileURLToPath } from 'node:url';
import { eventually, Host, launch, startFleet, Watched } from './fixture.mjs';

const folder = process.argv[2] ?? fileURLToPath(new URL('../../docs/pictures', import.meta.url));
const size = { viewport: { width: 1280, height: 760 } };

const browser = await launch();
await map();
await network();
await browser.close();

async function map() {
  const system = 91;
  const host = await Host.start();
  await host.up('emulated.toml', system);
  for (const name of ['Mcl', 'Path']) await host.timsctl('component', 'on', `${name}(${system}/0)`);
  const { page, context } = await Watched.open(browser, host, `#/map?robots=${system}`, size);
  await page.getByRole('button', { name: 'Send robot here' }).click();
  await page.getByRole('button', { name: 'Zoom out' }).click();
  const canvas = await page.getByRole('img', { name: /^Map/ }).boundingBox();
  // Through the door, into the room.
  const metre = await scaleOf(page);
  const at = { x: canvas.x + canvas.width / 2 + 2.6 * metre, y: canvas.y + canvas.height / 2 - 3.4 * metre };
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  await page.mouse.move(at.x + 60, at.y, { steps: 5 });
  await page.mouse.up();
  const north = async () => (await host.timsctl('component', 'data', `Position(${system}/0)`)).data.pos.x;
  await eventually(async () => (await north()) > 1500, 'the robot is on its way', 60_000);
  await page.screenshot({ path: `${folder}/console-map.png` });
  await context.close();
  await host.end();
}

// Pixels a metre.
async function scaleOf(page) {
  const text = await page.evaluate(() => document.querySelector('canvas.map').dataset.scale);
  return 1000 * Number(text);
}

async function network() {
  const [base, ...robots] = await startFleet(3);
  await robots[0].up('sim.toml', 1);
  const { page, context } = await Watched.open(browser, base, '#/network?tab=links', size);
  await page.getByRole('heading', { name: /robot3 up/ }).waitFor();
  await robots[2].killRouter();
  for (const heading of [/robot1 up/, /robot2 up/, /robot3 (silent|down)/])
    await page.getByRole('heading', { name: heading }).waitFor();
  await page.screenshot({ path: `${folder}/console-network.png` });
  await context.close();
  for (const host of [...robots, base]) await host.end();
}
