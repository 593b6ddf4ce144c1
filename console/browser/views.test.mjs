// Every command of every view: the bytes that arrive at the component are those that `timsctl msg pub` sends.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, afterEach, before, test } from 'node:test';
import { eventually, Host, launch, Watched } from './fixture.mjs';
import { addressOf, cameraData, Swarm } from './swarm.mjs';

const schema = JSON.parse(readFileSync(new URL('../src/codec/schema.json', import.meta.url), 'utf8'));
const system = 7;
const period = 50; // ms
const servoAt = 700; // its position

const classOf = (name) => schema.classes.find((each) => each.name === name);
const made = (struct) => Buffer.from(schema.structs.find(({ name }) => name === struct).made, 'hex');
const component = (name, instance = 0) => swarm.components.get(addressOf(system, classOf(name).id, instance));

let host;
let browser;
let swarm;

// Data in which everything has its default, and answers that are needed to go on.
const data = {
  Chassis: () => {
    const body = made('ChassisData');
    body.writeFloatLE(24.6, body.length - 8); // battery
    body.writeUInt32LE(addressOf(system, classOf('Pilot').id, 0), body.length - 4);
    return body;
  },
  Io: () => Buffer.from('0000000003000000010203', 'hex'),
  Gps: () => {
    const body = made('GpsData');
    body.writeInt32LE(2, 4); // 3D
    body.writeInt32LE(1500, 52); // north
    return body;
  },
  Position: () => made('PositionData'),
  ServoDrive: () => {
    const body = made('ServoDriveData');
    body.writeFloatLE(servoAt, 4);
    return body;
  },
  Clock: () => {
    const body = made('ClockData');
    body.writeBigInt64LE(0x7fff_ffff_ffff_ffffn, 28); // UTC
    return body;
  },
};
const unheard = 0x60; // no class
const answers = {
  Datalog: { 23: [-23, made('DatalogData')] },
  Position: { 26: [-22, made('PositionData')] },
  Chassis: { 22: [-21, made('ChassisParamData')] },
};

before(async () => {
  host = await Host.start();
  browser = await launch();
  swarm = await Swarm.start(host.tcp);
  for (const { name, id, messages } of schema.classes) {
    const struct = messages.find(({ name: message }) => message === 'DATA')?.body;
    if (struct === undefined || id < 0x10 || name === 'World') continue;
    swarm.add(addressOf(system, id, 0), data[name] ?? (() => made(struct)), period, answers[name] ?? {});
  }
  swarm.add(addressOf(system, classOf('Pilot').id, 1), () => made('PilotData'), period, {});
  swarm.add(addressOf(system, classOf('Datalog').id, 1), () => made('DatalogData'), period, {
    23: [-23, logList(addressOf(system, classOf('Ladar').id, 0), 'ladar.dat')],
  });
  swarm.add(addressOf(system, classOf('World').id, 0), () => made('WorldData'), period, {});
  swarm.add(addressOf(system, unheard, 0), () => Buffer.from('RACK'), period, { 33: [-33, Buffer.from('ok')] });
});

// A recorder's list of one stream.
function logList(stream, file) {
  const list = made('DatalogData');
  list.writeInt32LE(1, list.length - 4);
  const info = made('DatalogLogInfo');
  info.writeUInt32LE(stream, 4);
  info.write(file, 16, 'latin1');
  return Buffer.concat([list, info]);
}

after(async () => {
  swarm?.end();
  await browser?.close();
  await host?.end();
});

afterEach(Watched.closeAll);

// What the page sends while `act` is done, and what timsctl sends for `fields`.
async function compared(className, message, fields, act) {
  const { type } = classOf(className).messages.find(({ name }) => name === message);
  const target = component(className);
  target.commands.length = 0;
  await act();
  const sent = await eventually(() => target.commands.find((each) => each.type === type), `${className}.${message}`);
  target.commands.length = 0;
  await host.timsctl('msg', 'pub', '-y', `${className}(${system}/0)`, message.toLowerCase(), ...fields);
  const wanted = await eventually(() => target.commands.find((each) => each.type === type), 'that of timsctl');
  assert.equal(sent.body, wanted.body, `${className}.${message} ${fields}`);
}

// A page with the view of this class, and its parts.
async function opened(className) {
  const watched = await Watched.open(browser, host, `#/robot/${system}?tiles=${className}/0`);
  const tile = watched.page.getByRole('region', { name: `${className}/0`, exact: true });
  await tile.waitFor();
  return {
    watched,
    tile,
    click: (name) => tile.getByRole('button', { name, exact: true }).click(),
    fill: (name, text) => tile.getByLabel(name, { exact: true }).fill(text),
    // For what wants to be held.
    hold: async (name) => {
      const button = tile.getByRole('button', { name: new RegExp(`^${name} hold$`) });
      await button.scrollIntoViewIfNeeded();
      const { x, y, width, height } = await button.boundingBox();
      await watched.page.mouse.move(x + width / 2, y + height / 2);
      await watched.page.mouse.down();
      return () => watched.page.mouse.up();
    },
  };
}

async function held(view, name, compare) {
  let release;
  await compare(async () => {
    release = await view.hold(name);
  });
  await release();
}

test('Chassis: who may drive', async () => {
  const view = await opened('Chassis');
  await compared('Chassis', 'SET_ACTIVE_PILOT', [`activePilot=Pilot(${system}/1)`], () =>
    view.tile.getByLabel(`Pilot(${system}/1)`).click(),
  );
  await compared('Chassis', 'SET_ACTIVE_PILOT', ['activePilot=0xffffff00'], () =>
    view.tile.getByLabel('nobody').click(),
  );
  await compared('Chassis', 'SET_ACTIVE_PILOT', ['activePilot=0x07180200'], async () => {
    await view.fill('Address of another pilot, in hex', '07180200');
    await view.click('Let it drive');
  });
  await view.watched.close();
});

test('Odometry and Position', async () => {
  let view = await opened('Odometry');
  await compared('Odometry', 'RESET', [], () => view.click('Set to zero'));
  await view.watched.close();
  view = await opened('Position');
  await compared(
    'Position',
    'UPDATE',
    ['pos.x=1500', 'pos.y=-250', 'pos.rho=1.5707963267948966', 'var.x=300', 'var.y=300', 'var.rho=0.2'],
    async () => {
      await view.tile.getByLabel('North in m', { exact: true }).first().fill('1.5');
      await view.tile.getByLabel('East in m', { exact: true }).first().fill('-0.25');
      await view.fill('Heading in °', '90');
      await view.click('It is here');
    },
  );
  await compared('Position', 'UPDATE', ['pos.x=1500'], () => view.click(`It is where Gps(${system}/0) is`));
  await view.watched.close();
});

test('Position: goals of a file, and the way to them', async () => {
  const view = await opened('Position');
  await view.tile.getByText('Goals', { exact: true }).click();
  await view.tile.getByText('No goal is set').waitFor();
  await compared('Position', 'UTM_TO_POS', ['zone=32', 'band=18', 'easting=550000250', 'northing=5800000500'], () =>
    view.tile.getByLabel('File of goals').setInputFiles({
      name: 'goals.txt',
      mimeType: 'text/plain',
      buffer: Buffer.from('# one\n32U 550000.25m E 5800000.5m N\n'),
    }),
  );
  await view.tile.getByText('1 of 1').waitFor();
  await view.tile.getByLabel('North in m', { exact: true }).nth(1).fill('30');
  await view.tile.getByLabel('East in m', { exact: true }).nth(1).fill('40');
  await view.click('Set goal');
  await view.tile.getByRole('img', { name: /^the goal is 50.00 m away, 53.1° from ahead/ }).waitFor();
  await view.watched.close();
});

test('Pilot: hold and destination', async () => {
  const view = await opened('Pilot');
  await compared('Pilot', 'HOLD_COMMAND', ['holdState=1'], () => view.click('Hold'));
  await compared('Pilot', 'HOLD_COMMAND', ['holdState=0'], () => view.click('Go on'));
  await compared('Pilot', 'SET_DESTINATION', ['pos.x=2000', 'pos.y=3000', 'pos.z=-500', 'speed=400'], async () => {
    await view.fill('North in m', '2');
    await view.fill('East in m', '3');
    await view.fill('Down in m', '-0.5');
    await view.fill('Speed in m/s', '0.4');
    await view.click('Set destination');
  });
  await view.watched.close();
});

test('ServoDrive and PtzDrive: what sets them going is held', async () => {
  let view = await opened('ServoDrive');
  await compared('ServoDrive', 'MOVE_POS', [`position=${servoAt + 100}`], () => view.click('+100'));
  await compared('ServoDrive', 'MOVE_POS', [`position=${servoAt - 100}`], () => view.click('−100'));
  await compared('ServoDrive', 'MOVE_VEL', ['vel=0'], () => view.click('Stop'));
  await view.fill('Target', '25');
  await compared('ServoDrive', 'MOVE_POS', ['position=25'], () => view.click('Go there'));
  await held(view, 'Turn at this velocity', (act) => compared('ServoDrive', 'MOVE_VEL', ['vel=25'], act));
  await held(view, 'Home', (act) => compared('ServoDrive', 'HOME', [], act));
  await view.watched.close();
  view = await opened('PtzDrive');
  await view.fill('Pan in °', '180');
  await view.fill('Zoom in %', '10');
  await compared('PtzDrive', 'MOVE_POS', ['posPan=3.141592653589793', 'posZoom=10'], () => view.click('Go there'));
  await held(view, 'Turn at these per second', (act) =>
    compared('PtzDrive', 'MOVE_VEL', ['velPan=3.141592653589793', 'velZoom=10'], act),
  );
  await held(view, 'Home', (act) => compared('PtzDrive', 'HOME', [], act));
  await compared('PtzDrive', 'MOVE_VEL', [], () => view.click('Stop'));
  await view.watched.close();
});

test('a button that is held when its view is left has done nothing', async () => {
  const view = await opened('ServoDrive');
  const { page } = view.watched;
  await page.clock.install();
  for (const each of ['ServoDrive', 'Chassis']) component(each).commands.length = 0;
  const release = await view.hold('Home');
  await page.evaluate(() => {
    location.hash = '#/fleet';
  });
  await view.tile.waitFor({ state: 'detached' });
  await page.clock.runFor(5000);
  await release();
  await page
    .getByRole('button', { name: 'Stop all robots' })
    .or(page.getByLabel(`Stop robot ${system}`))
    .first()
    .click();
  await eventually(() => component('Chassis').commands.length > 0, 'what was sent later has arrived');
  assert.deepEqual(component('ServoDrive').commands, []);
  await view.watched.close();
});

test('a servo whose position is not known does not move by a step', async () => {
  swarm.add(addressOf(system, classOf('ServoDrive').id, 1), undefined, period, {});
  const watched = await Watched.open(browser, host, `#/robot/${system}?tiles=ServoDrive/1`);
  const tile = watched.page.getByRole('region', { name: 'ServoDrive/1', exact: true });
  await tile.getByRole('button', { name: 'Go there' }).waitFor();
  for (const name of ['+100', '−100']) assert(await tile.getByRole('button', { name }).isDisabled(), name);
  await watched.close();
});

test('Io and Vehicle', async () => {
  let view = await opened('Io');
  await view.tile.getByLabel('Values').waitFor();
  await view.fill('Index', '1');
  await view.fill('Value in hex', 'a5');
  component('Io').commands.length = 0;
  await view.click('Set');
  await eventually(() => component('Io').commands.some(({ body }) => body === '000000000300000001a503'), 'the byte');
  await view.watched.close();
  view = await opened('Vehicle');
  await view.tile.getByText('throttle', { exact: true }).waitFor();
  await view.tile.getByLabel(/^Brake/).fill('40');
  await view.tile.getByLabel('Gear').selectOption('2');
  await view.tile.getByLabel('Engine').check();
  await held(view, 'Set', (act) => compared('Vehicle', 'SET_VALUE', ['brake=40', 'gear=2', 'engine=1'], act));
  await view.watched.close();
});

test('Camera: its format', async () => {
  const view = await opened('Camera');
  await view.tile.getByText('Format', { exact: true }).click();
  await view.tile.getByLabel('Size').selectOption('320x240');
  await compared('Camera', 'SET_FORMAT', ['width=320', 'height=240', 'depth=-1', 'mode=-1'], () => view.click('Set'));
  await view.tile.getByLabel('Mode').selectOption('jpeg');
  await compared('Camera', 'SET_FORMAT', ['width=320', 'height=240', 'depth=-1', 'mode=41'], () => view.click('Set'));
  await view.watched.close(); // its picture of no pixels is refused in words
});

test('what a view shows is saved: once, or each', async () => {
  component('Camera').data = cameraData(16, 12);
  for (const [name, button, file] of [
    ['Camera', 'Save picture', /\.png$/],
    ['Scan2d', 'Save points', /^scan-\d+\.csv$/],
  ]) {
    const view = await opened(name);
    const saved = async (act) => {
      const download = view.watched.page.waitForEvent('download');
      await act();
      assert.match((await download).suggestedFilename(), file);
    };
    await saved(() => view.click(button));
    const each = view.tile.getByLabel('save each');
    await saved(() => each.check());
    await saved(() => {}); // the next one
    await each.uncheck();
    await view.watched.close();
  }
});

test('maps are loaded and saved by name', async () => {
  let view = await opened('FeatureMap');
  await view.fill("Name of the map's file", 'floor.dxf');
  await compared('FeatureMap', 'LOAD_MAP', ['name=floor.dxf'], () => view.click('Load'));
  await compared('FeatureMap', 'SAVE_MAP', ['name=floor.dxf'], () => view.click('Save'));
  await view.watched.close();
  view = await opened('Mcl');
  await view.fill("Name of the map's file", 'hall.dxf');
  await compared('Mcl', 'LOAD_MAP', ['name=hall.dxf'], () => view.click('Load'));
  await view.watched.close();
});

test('Datalog and Planner', async () => {
  let view = await opened('Datalog');
  await compared('Datalog', 'INIT_LOG', [], async () => {
    await host.timsctl('component', 'off', `Datalog(${system}/0)`);
    await view.click('List the streams anew');
  });
  await compared('Datalog', 'SET_LOG', ['logPathName=/tmp/log'], async () => {
    await view.fill('Folder', '/tmp/log');
    await view.click('Record');
  });
  await eventually(() => component('Datalog').on, 'it records');
  await view.click('Stop recording');
  await eventually(() => !component('Datalog').on, 'it has ended');
  await view.watched.close();
  view = await opened('Planner');
  await view.fill('Command', 'go home');
  component('Planner').commands.length = 0;
  await view.click('Send');
  const { body } = await eventually(() => component('Planner').commands[0], 'the command');
  assert(Buffer.from(body, 'hex').toString('latin1').includes('go home'));
  await view.watched.close();
});

test('the recorder page shows the recorder of each robot', async () => {
  const watched = await Watched.open(browser, host, '#/recorder');
  const box = watched.page.getByRole('region', { name: `Datalog(${system}/0)` });
  await box.getByRole('button', { name: 'Record', exact: true }).click();
  await eventually(() => component('Datalog').on, 'it records');
  await box.getByRole('button', { name: 'Stop recording' }).click();
  await eventually(() => !component('Datalog').on, 'it has ended');
  await watched.close();
});

test('a class without a view has its fields', async () => {
  const view = await opened('World');
  await view.tile.getByRole('row', { name: /^peopleMove 1/ }).waitFor();
  await view.watched.close();
});

test('a class that is not described has its bytes, and takes some', async () => {
  const view = await opened(`${unheard}`);
  await view.tile.getByText('0000  52 41 43 4b').waitFor();
  await view.click('Commands');
  await view.fill('Type', '33');
  await view.fill('Body in hex, little endian', '01 fe');
  await view.click('Send');
  await view.tile.getByText('Answered by type -33, 2 bytes').waitFor();
  const { commands } = swarm.components.get(addressOf(system, unheard, 0));
  assert.deepEqual(
    commands.map(({ type, body }) => [type, body]),
    [[33, '01fe']],
  );
  await view.watched.close();
});

test('a scan of space is shown by its range image, without its points', async () => {
  const image = made('Scan3dRangeImageData');
  image.writeInt32LE(8000, 8); // the farthest range
  component('Scan3d').answers[21] = [-21, image];
  component('Scan3d').listeners.clear();
  const view = await opened('Scan3d');
  await view.tile.getByText('8.00 m').waitFor();
  assert.equal(component('Scan3d').listeners.size, 0);
  await view.watched.close();
});

test('a time that is none is said to be none', async () => {
  const view = await opened('Clock');
  await view.tile.getByText('no time').waitFor();
  await view.watched.close();
});

test('a view that fails leaves the others alone, and is tried again', async () => {
  const watched = await Watched.open(browser, host);
  const { page } = watched;
  await page.evaluate(() => {
    globalThis.trueTime = Date.prototype.getTime;
    Date.prototype.getTime = () => {
      throw new Error('no such time');
    };
  });
  await page.goto(`${host.address}/#/robot/${system}?tiles=Clock/0,Compass/0`);
  const clock = page.getByRole('region', { name: 'Clock/0' });
  await clock.getByRole('alert').getByText('no such time').waitFor();
  await page.getByRole('region', { name: 'Compass/0' }).getByText('Orientation').waitFor();
  await page.evaluate(() => {
    Date.prototype.getTime = globalThis.trueTime;
  });
  await clock.getByRole('button', { name: 'Try again' }).click();
  await clock.getByText('synchronised').waitFor();
  await watched.close();
});

test('why a recording is refused stays in sight', async () => {
  const { answers } = component('Datalog');
  answers[22] = [-1, Buffer.from('the disk is full')];
  await host.timsctl('component', 'off', `Datalog(${system}/0)`);
  const view = await opened('Datalog');
  await view.fill('Folder', '/tmp/log');
  await view.click('Record');
  await view.tile.getByText('the disk is full').waitFor();
  const polls = () => swarm.journal.filter(({ type }) => type === 23).length;
  swarm.journal.length = 0;
  await eventually(() => polls() >= 2, 'its state is asked for');
  assert.equal(await view.tile.getByText('the disk is full').count(), 1);
  delete answers[22];
  await view.watched.close();
});

test('all recorders begin with what was edited: period and file of a stream', async () => {
  for (const instance of [0, 1]) await host.timsctl('component', 'off', `Datalog(${system}/${instance})`);
  const second = component('Datalog', 1);
  const watched = await Watched.open(browser, host, '#/recorder');
  const { page } = watched;
  const box = page.getByRole('region', { name: `Datalog(${system}/1)` });
  await box.getByLabel(`File of Ladar(${system}/0)`).fill('my.dat');
  await box.getByLabel(`Period of Ladar(${system}/0) in ms`).fill('250');
  await box.getByLabel(`Record Ladar(${system}/0)`).check();
  second.commands.length = 0;
  await page.getByRole('button', { name: 'Record at all' }).click();
  await eventually(() => second.on && component('Datalog').on, 'both record');
  const info = Buffer.from(second.commands.find(({ type }) => type === 22).body, 'hex').subarray(48);
  assert.deepEqual([info.readInt32LE(0), info.readUInt32LE(8)], [1, 250]);
  assert.equal(info.toString('latin1', 16, 23), 'my.dat\0');
  await page.getByRole('button', { name: 'Stop all' }).click();
  await eventually(() => !second.on && !component('Datalog').on, 'both have ended');
  await watched.close();
});

test('every command of a class is a form', async () => {
  const view = await opened('Scan3d');
  await view.click('Commands');
  await compared('Scan3d', 'STORE_DATA', [], async () => {
    await view.tile.getByLabel('Command').selectOption({ label: 'STORE_DATA' });
    await view.click('Send');
  });
  await view.watched.close();
});

test('a plot keeps its samples when a curve is added, and shows the time that is chosen, also while it is paused', async () => {
  const watched = await Watched.open(browser, host, `#/plots?curves=Position(${system}/0).pos.x`);
  const { page } = watched;
  const saved = async () => {
    const download = page.waitForEvent('download');
    await page.getByRole('button', { name: 'Save CSV' }).click();
    return readFileSync(await (await download).path(), 'utf8').split('\n');
  };
  const [, first] = await eventually(async () => {
    const lines = await saved();
    return lines.length > 4 && lines;
  }, 'samples');
  await page.getByLabel('Field to plot').fill(`Chassis(${system}/0).vx`);
  await page.getByRole('button', { name: 'Add' }).click();
  await page.getByRole('button', { name: `Remove Chassis(${system}/0).vx` }).waitFor();
  assert.equal((await saved())[1], first);
  await page.getByRole('button', { name: 'Pause' }).click();
  const picture = () => page.evaluate(() => document.querySelector('.plot canvas').toDataURL());
  const before = await picture();
  await page.getByLabel('Time that is shown').selectOption('10 min');
  await eventually(async () => (await picture()) !== before, 'it is drawn anew');
  assert.match(page.url(), /span=600/);
  await watched.close();
});

test('every view is accessible, light and dark', async () => {
  const atOnce = 7;
  const names = schema.classes.filter(({ id }) => swarm.components.has(addressOf(system, id, 0)));
  const tiles = [...names.map(({ name }) => `${name}/0`), `${unheard}/0`];
  const watched = await Watched.open(browser, host, '#/fleet', { viewport: { width: 1440, height: 3000 } });
  const { page } = watched;
  for (let i = 0; i < tiles.length; i += atOnce) {
    const shown = tiles.slice(i, i + atOnce);
    await page.goto(`${host.address}/#/robot/${system}?tiles=${shown.join(',')}`);
    await page.getByRole('region', { name: shown.at(-1), exact: true }).waitFor();
    await eventually(async () => (await page.getByText('Waiting for data').count()) === 0, `data of ${shown}`);
    for (const colorScheme of ['light', 'dark']) {
      await page.emulateMedia({ colorScheme });
      assert.deepEqual(await watched.seriousFindings(), [], `${colorScheme}: ${shown}`);
    }
  }
  await watched.close();
});

test('the form of a command takes a comma for a point, and sends nothing in place of a number', async () => {
  const view = await opened('ServoDrive');
  await view.click('Commands');
  await view.tile.getByLabel('Command').selectOption({ label: 'MOVE_POS' });
  await compared('ServoDrive', 'MOVE_POS', ['position=1.5'], async () => {
    await view.fill('position', '1,5');
    await view.click('Send');
  });
  const box = view.tile.getByLabel('position', { exact: true });
  component('ServoDrive').commands.length = 0;
  for (const wrong of ['', 'fast']) {
    await box.fill(wrong);
    await view.click('Send');
    assert.match(await box.evaluate((element) => element.validationMessage), /is no number/);
  }
  await compared('ServoDrive', 'MOVE_POS', ['position=2'], async () => {
    await box.fill('2');
    await view.click('Send');
    await eventually(() => component('ServoDrive').commands.length > 0, 'it is sent');
    assert.equal(component('ServoDrive').commands.length, 1, 'nothing before it');
  });
  await view.watched.close();
});

// Places of the map are chosen by keys: the middle of the map is where the robot is.
async function onMap(action, act) {
  const watched = await Watched.open(browser, host, `#/map?robots=${system}`);
  const { page } = watched;
  await page.getByRole('cell', { name: '0.00 m' }).first().waitFor();
  await page.getByLabel('Action').selectOption(action);
  const map = page.getByRole('img', { name: /^Map of/ });
  await map.focus();
  await act(page.keyboard, page);
  await watched.close();
}

test('the map: position, estimate, walls, waypoints', async () => {
  const deviation = ['var.x=300', 'var.y=300', 'var.rho=0.2'];
  await onMap('position', (keyboard) =>
    compared('Position', 'UPDATE', ['pos.rho=0.17453292519943295', ...deviation], async () => {
      await keyboard.press('Enter');
      await keyboard.press('h'); // 10 degrees clockwise
      await keyboard.press('Enter');
    }),
  );
  await onMap('path-goal', (keyboard) =>
    compared('Path', 'SET_DESTINATION', ['speed=10000'], async () => {
      await keyboard.press('Enter');
      await keyboard.press('Enter');
    }),
  );
  await onMap('estimate', async (keyboard) => {
    component('ObjRecog').commands.length = 0;
    await keyboard.press('Enter');
    await keyboard.press('Enter');
    const { body } = await eventually(() => component('ObjRecog').commands[0], 'the estimate');
    assert.equal(Buffer.from(body, 'hex').readInt32LE(52), 1, 'one object');
  });
  await onMap('wall-1', async (keyboard) => {
    component('FeatureMap').commands.length = 0;
    await keyboard.press('Enter');
    for (let i = 0; i < 3; ++i) await keyboard.press('Shift+ArrowRight');
    await keyboard.press('Enter');
    const { body } = await eventually(() => component('FeatureMap').commands[0], 'the wall');
    const wall = Buffer.from(body, 'hex');
    const [x, y, x2, y2, length, rho] = Array.from({ length: 6 }, (_, i) => wall.readDoubleLE(4 + 8 * i));
    assert(Math.abs(x) < 1e-6 && Math.abs(y) < 1e-6 && Math.abs(x2) < 1e-6 && y2 > 0, `${[x, y, x2, y2]}`);
    assert(Math.abs(length - y2) < 1e-6 && Math.abs(rho - Math.PI / 2) < 1e-6);
    assert.equal(wall.readInt32LE(68), 1, 'its layer');
  });
  await onMap('waypoint', async (keyboard, page) => {
    const path = component('Path');
    path.commands.length = 0;
    for (let i = 0; i < 2; ++i) {
      await keyboard.press('Enter');
      await keyboard.press('Enter');
    }
    await page.getByRole('region', { name: 'Waypoints' }).getByRole('button', { name: 'Send' }).click();
    await eventually(() => path.commands.some(({ type }) => type === 21), 'MAKE');
    const list = Buffer.from(path.commands.find(({ type }) => type === 24).body, 'hex');
    assert.equal(list.readInt32LE(0), 2);
    assert.equal(list.readInt32LE(12), 500, 'speed, mm/s');
  });
});

test('a component begins anew: it goes off, and on again', async () => {
  const watched = await Watched.open(browser, host, `#/robot/${system}?tiles=Gyro/0`);
  const address = addressOf(system, classOf('Gyro').id, 0);
  swarm.journal.length = 0;
  await watched.page.getByRole('button', { name: 'Commands' }).click();
  await watched.page.getByRole('button', { name: 'Restart Gyro/0' }).click();
  const switched = () =>
    swarm.journal.filter(({ dest, type }) => dest === address && (type === 1 || type === 2)).map(({ type }) => type);
  await eventually(() => switched().join() === '2,1', 'OFF, then ON');
  await watched.page.getByRole('button', { name: /^Gyro\/0: on/ }).waitFor();
  await watched.close();
});

test('the battery of a robot is on its card, as long as that is in sight', async () => {
  for (const { listeners } of swarm.components.values()) listeners.clear();
  const watched = await Watched.open(browser, host);
  const { page } = watched;
  await page.getByText('battery 24.6 V').waitFor();
  assert.equal(swarm.listeners, 1, 'nothing else is asked for');
  await page.goto(`${host.address}/#/messages`);
  await eventually(() => swarm.listeners === 0, 'nobody listens');
  await watched.close();
});

test('what is scrolled out of sight, or closed, sends nothing', async () => {
  for (const { listeners } of swarm.components.values()) listeners.clear();
  const names = ['Chassis', 'Odometry', 'Position', 'Pilot', 'Ladar', 'Scan2d', 'Gyro', 'Vehicle', 'Io', 'ObjRecog'];
  const watched = await Watched.open(browser, host, `#/robot/${system}?tiles=${names.map((n) => `${n}/0`).join(',')}`, {
    viewport: { width: 700, height: 600 },
  });
  const { page } = watched;
  const listeners = (name) => component(name).listeners.size;
  await eventually(() => listeners('Chassis') === 1 && listeners('ObjRecog') === 0, 'the first is in sight');
  await page.getByRole('region', { name: 'ObjRecog/0' }).scrollIntoViewIfNeeded();
  await eventually(() => listeners('ObjRecog') === 1 && listeners('Chassis') === 0, 'now the last is');
  await page.goto(`${host.address}/#/messages`);
  await eventually(() => swarm.listeners === 0, 'nobody listens');
  await watched.close();
});
