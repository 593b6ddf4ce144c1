// What is done on the map: walls that are marked, deleted and moved, goals behind the robot, and pictures below it.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { after, afterEach, before, test } from 'node:test';
import { eventually, Host, launch, Watched } from './fixture.mjs';
import { addressOf, Swarm } from './swarm.mjs';

const schema = JSON.parse(readFileSync(new URL('../src/codec/schema.json', import.meta.url), 'utf8'));
const system = 7;
const period = 50; // ms
const wall = { length: 2000, layer: 1, number: 0 }; // along north, 1 m east of the robot

let host;
let browser;
let swarm;

const classOf = (name) => schema.classes.find((each) => each.name === name);
const made = (name) => Buffer.from(schema.structs.find((struct) => struct.name === name).made, 'hex');
const component = (name, instance = 0) => swarm.components.get(addressOf(system, classOf(name).id, instance));

function mapOf(feature) {
  const body = made('FeatureMapData');
  body.writeInt32LE(1, body.length - 4);
  return Buffer.concat([body, feature]);
}

// A map of one wall.
function featureMap() {
  const feature = made('FeatureMapDataPoint');
  for (const [i, value] of [-1000, 1000, 1000, 1000, wall.length, 0, 0, 1].entries())
    feature.writeDoubleLE(value, 8 * i);
  feature.writeInt32LE(wall.layer, 64);
  feature.writeInt32LE(10, 68); // a line
  return mapOf(feature);
}

before(async () => {
  host = await Host.start();
  browser = await launch();
  swarm = await Swarm.start(host.tcp);
  const data = { FeatureMap: featureMap };
  const answers = { Chassis: { 22: [-21, made('ChassisParamData')] } };
  for (const name of ['Chassis', 'Pilot', 'Position', 'FeatureMap'])
    swarm.add(
      addressOf(system, classOf(name).id, 0),
      data[name] ?? (() => made(`${name}Data`)),
      period,
      answers[name] ?? {},
    );
  for (const [name, instance] of [
    ['Position', 1],
    ['Path', 0],
    ['Path', 1],
  ])
    swarm.add(addressOf(system, classOf(name).id, instance), () => made(`${name}Data`), period, {});
});

after(async () => {
  swarm?.end();
  await browser?.close();
  await host?.end();
});

afterEach(Watched.closeAll);

async function onMap(action) {
  const watched = await Watched.open(browser, host, `#/map?robots=${system}`);
  const { page } = watched;
  await page.getByRole('cell', { name: '0.00 m' }).first().waitFor();
  if (action !== undefined) await page.getByLabel('Action').selectOption(action);
  const map = page.getByRole('img', { name: /^Map of/ });
  const box = await map.boundingBox();
  const metre = 1000 * Number(await map.getAttribute('data-scale')); // pixels
  // In m from the robot, which is in the middle, north up.
  const press = (north, east) =>
    map.click({ position: { x: box.width / 2 + east * metre, y: box.height / 2 - north * metre } });
  return { watched, page, map, press };
}

test('a wall is marked, and said which one it is', async () => {
  const { watched, page, press } = await onMap('wall-mark');
  await eventually(() => component('FeatureMap').listeners.size > 0, 'the map is asked for');
  await eventually(async () => {
    await press(0.5, 1);
    return (await page.getByText('Wall 0 of 1, layer 1: 2.00 m').count()) > 0;
  }, 'it is marked');
  await press(-1.5, -1);
  await page.getByText('no wall of the map is there').waitFor();
  assert.equal(component('FeatureMap').commands.length, 0, 'to mark commands nothing');
  await watched.close();
});

test('each instance of Position and Path is drawn; in the table, a robot has its colour', async () => {
  const { watched, page } = await onMap();
  const isFollowed = (name, instance) => component(name, instance).listeners.size > 0;
  for (const name of ['Position', 'Path'])
    await eventually(() => isFollowed(name, 0) && isFollowed(name, 1), `both instances of ${name} are followed`);
  const swatch = page.getByRole('rowheader', { name: `${system}` }).locator('.swatch');
  assert.equal(await swatch.evaluate((element) => getComputedStyle(element).backgroundColor), 'rgb(11, 95, 206)');
  await watched.close();
});

test('a wall is deleted', async () => {
  const { watched, press } = await onMap('wall-delete');
  component('FeatureMap').commands.length = 0;
  await eventually(() => component('FeatureMap').listeners.size > 0, 'the map is asked for');
  await press(0, 1);
  const { type } = await eventually(() => component('FeatureMap').commands[0], 'the command');
  assert.equal(type, classOf('FeatureMap').messages.find(({ name }) => name === 'DELETE_LINE').type);
  await watched.close();
});

test('a wall is moved, and the step taken back; the map is saved', async () => {
  const { watched, page, map } = await onMap('wall-move');
  const features = component('FeatureMap');
  const typeOf = (name) => classOf('FeatureMap').messages.find((message) => message.name === name).type;
  features.commands.length = 0;
  await eventually(() => features.listeners.size > 0, 'the map is asked for');
  const box = await map.boundingBox();
  const metre = 1000 * Number(await map.getAttribute('data-scale'));
  const at = (north, east) => [box.x + box.width / 2 + east * metre, box.y + box.height / 2 - north * metre];
  const moved = async () => {
    await page.mouse.move(...at(0, 1));
    await page.mouse.down();
    await page.mouse.move(...at(0.5, 1.5));
    await page.mouse.up();
    return features.commands.find(({ type }) => type === typeOf('DISPLACE_LINE'));
  };
  const { body } = await eventually(moved, 'the command');
  const feature = Buffer.from(body, 'hex').subarray(4, 4 + made('FeatureMapDataPoint').length);
  const [x, y, x2, y2] = [0, 1, 2, 3].map((i) => feature.readDoubleLE(8 * i));
  assert(Math.hypot(x + 500, y - 1500) < 100 && Math.hypot(x2 - 1500, y2 - 1500) < 100, `${[x, y, x2, y2]}`);
  features.data = () => mapOf(feature);
  features.commands.length = 0;
  await page.getByRole('button', { name: 'Undo' }).click();
  const back = await eventually(() => features.commands[0], 'it is moved back');
  assert.equal(back.type, typeOf('DISPLACE_LINE'));
  assert.equal(Buffer.from(back.body, 'hex').readDoubleLE(4 + 8), 1000, '1 m east of the robot');
  await page.getByText('The wall is where it was').waitFor();
  assert.equal(await page.getByRole('button', { name: 'Undo' }).count(), 0);
  features.data = featureMap;
  await page.getByText('Walls', { exact: true }).click();
  await page.getByLabel("Name of the map's file").fill('hall.dxf');
  await page.getByRole('button', { name: 'Save', exact: true }).click();
  await eventually(() => features.commands.some(({ type }) => type === typeOf('SAVE_MAP')), 'it is saved');
  await watched.close();
});

test('waypoints that are not sent stay while another page is visited', async () => {
  const { watched, page, press } = await onMap('waypoint');
  await press(1, 0);
  const list = page.getByRole('region', { name: 'Waypoints' });
  await list.getByText(/^1\. /).waitFor();
  await page.goto(`${host.address}/#/messages`);
  await page.getByRole('heading', { name: 'Messages' }).waitFor();
  await page.goto(`${host.address}/#/map?robots=${system}`);
  await list.getByText(/^1\. /).waitFor();
  await watched.close();
});

const setDestination = () => classOf('Pilot').messages.find(({ name }) => name === 'SET_DESTINATION').type;

async function goalAt(north, turns) {
  const { watched, page, map, press } = await onMap('goal');
  component('Pilot').commands.length = 0;
  if (turns === undefined) await press(north, 0);
  else {
    // By keys: down from the middle, and turned.
    await map.focus();
    await page.keyboard.press('Enter');
    for (let i = 0; i < 20; ++i) await page.keyboard.press('ArrowDown');
    for (let i = 0; i < turns; ++i) await page.keyboard.press('h');
    await page.keyboard.press('Enter');
  }
  const { body } = await eventually(
    () => component('Pilot').commands.find(({ type }) => type === setDestination()),
    'the destination',
  );
  await watched.close();
  const bytes = Buffer.from(body, 'hex');
  return { north: bytes.readInt32LE(0), speed: bytes.readInt32LE(24) };
}

test('a robot backs to a goal behind it, where it looks the same way, and turns round for others', async () => {
  const ahead = await goalAt(2);
  assert(ahead.north > 1500 && ahead.speed > 0, JSON.stringify(ahead));
  const behind = await goalAt(-2);
  assert(behind.north < -1500 && behind.speed < 0, JSON.stringify(behind));
  const sameWay = await goalAt(-2, 0);
  assert(sameWay.north < 0 && sameWay.speed < 0, JSON.stringify(sameWay));
  const turned = await goalAt(-2, 18); // 180 degrees
  assert(turned.north < 0 && turned.speed > 0, JSON.stringify(turned));
});

test('a picture lies below the map, and a big one is cut into sections', async () => {
  const { watched, page } = await onMap();
  await page.getByText('Background', { exact: true }).click();
  const picture = await page.evaluate(async () => {
    const canvas = new OffscreenCanvas(1500, 700);
    const context = canvas.getContext('2d');
    context.fillStyle = '#123456';
    context.fillRect(0, 0, 1500, 700);
    return [...new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer())];
  });
  await page.getByLabel('Pictures and world files').setInputFiles([
    { name: 'aerial.png', mimeType: 'image/png', buffer: Buffer.from(picture) },
    { name: 'aerial.pgw', mimeType: 'text/plain', buffer: Buffer.from('0.1\n0\n0\n-0.1\n-74.95\n34.95\n') },
  ]);
  await page.getByRole('button', { name: 'Show', exact: true }).click();
  const isBelow = () =>
    page.evaluate(() => {
      const map = document.querySelector('canvas.map');
      const [red, green, blue] = map.getContext('2d').getImageData(3, map.height - 30, 1, 1).data;
      return [red, green, blue].join() === [0x12, 0x34, 0x56].join();
    });
  await eventually(isBelow, 'the picture is below the map');
  const saved = page.waitForEvent('download');
  await page.getByRole('button', { name: 'Cut into sections' }).click();
  const archive = await (await saved).path();
  const names = execFileSync('tar', ['-tf', archive], { encoding: 'utf8' }).trim().split('\n');
  assert.deepEqual(
    names,
    ['1-0-0', '1-0-1', '2-0-0'].flatMap((name) => [`aerial-${name}.png`, `aerial-${name}.pgw`]),
  );
  const worldFile = execFileSync('tar', ['-xOf', archive, 'aerial-1-0-1.pgw'], { encoding: 'utf8' });
  assert.match(worldFile, /^0\.1\n0\n0\n-0\.1\n27\.4/, '1024 pixels further east');
  await page.getByRole('button', { name: 'Remove' }).click();
  await eventually(async () => !(await isBelow()), 'it is removed');
  await watched.close();
});
