import assert from 'node:assert/strict';
import { test } from 'node:test';
import { flags } from '../tims/header';
import {
  classId,
  className,
  decodeData,
  decodeMessage,
  decodeStruct,
  encodeCommand,
  encodeMessage,
  encodeNamed,
  findMessage,
  messagesOf,
  structOf,
  valueName,
} from './catalogue';
import { shortFloat, toJson } from './json';
import { bytesOfHex, type Fields, Struct } from './struct';
import { bytesOf, shownText, textOf } from './text';
import type { Elements } from './views';

const little = flags.bodyLittleEndian;
const big = 0;
const chassis = classId('Chassis')!;
const text = (value: Fields, struct: Struct) => toJson(struct, value, String);

test('classes and messages by number and name', () => {
  assert.equal(className(chassis), 'Chassis');
  assert.equal(className(200), undefined);
  assert.equal(findMessage(chassis, 'MOVE')?.type, 21);
  assert.equal(findMessage(chassis, 21)?.body?.name, 'ChassisMoveData');
  assert.equal(findMessage(chassis, 'GET_STATUS')?.type, 3);
  assert.equal(findMessage(chassis, 99), undefined);
  assert.ok(messagesOf().length > 20);
  assert.deepEqual(messagesOf(200), []);
});

test('bodies of both byte orders', () => {
  const body = bytesOfHex('000000c800000000bf000000');
  assert.deepEqual(decodeMessage(chassis, 21, body, big), { vx: 200, vy: 0, omega: -0.5 });
  assert.deepEqual(encodeNamed('Chassis.MOVE', { vx: 200, omega: -0.5 }), {
    type: 21,
    body: bytesOfHex('c800000000000000000000bf'),
  });
  assert.deepEqual(encodeNamed('GET_STATUS'), { type: 3, body: new Uint8Array() });
  assert.throws(() => decodeMessage(chassis, 99, body, big), /Chassis: no body is known of messages of type 99/);
});

test('missing fields have the defaults of C++', () => {
  assert.equal(decodeStruct('Scan2dData', structOf('Scan2dData').encode({}), little).sectorNum, 1);
  const waypoints = structOf('PilotMultiDestData').encode({ points: [{ speed: 5 }] });
  assert.deepEqual(decodeStruct('PilotMultiDestData', waypoints, little).points[0]?.pos.x, 0);
});

test('numbers are checked when they are sent', () => {
  const move = (vx: unknown) => encodeMessage(chassis, 21, { vx });
  assert.doesNotThrow(() => move(2147483647));
  assert.doesNotThrow(() => move(-2147483648));
  for (const wrong of [2147483648, -2147483649, 0.5, Number.NaN, '5', null, undefined, 5n * 10n ** 12n])
    assert.throws(
      () => move(wrong),
      /ChassisMoveData\.vx is .*: expected a whole number from -2147483648 to 2147483647/,
    );
  const omega = (value: unknown) =>
    decodeMessage(chassis, 21, encodeMessage(chassis, 21, { omega: value }), little).omega;
  assert.equal(omega(Number.POSITIVE_INFINITY), Number.POSITIVE_INFINITY);
  assert.ok(Number.isNaN(omega(null)));
  assert.throws(() => omega('fast'), /ChassisMoveData\.omega is fast: expected a number/);
});

test('a command with a number that is not finite is refused, wherever it stands', () => {
  for (const wrong of [Number.NaN, Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY])
    assert.throws(
      () => encodeNamed('Chassis.MOVE', { omega: wrong }),
      /ChassisMoveData\.omega is -?(NaN|Infinity): expected a number/,
    );
  const pilot = findMessage(classId('Pilot')!, 'SET_MULTI_DESTINATION')!;
  assert.throws(
    () => encodeCommand(pilot, { points: [{}, { pos: { rho: null } }] }),
    /PilotMultiDestData\.points\.1\.pos\.rho is null: expected a number/,
  );
  assert.doesNotThrow(() => encodeCommand(pilot, { points: [{ pos: { rho: 1 } }] }));
});

test('numbers of 64 bits are exact', () => {
  const runtime = structOf('RuntimeData');
  const send = (loops: unknown) => runtime.decode(runtime.encode({ loops }), true).loops;
  assert.equal(send(2 ** 53 - 1), 2 ** 53 - 1);
  assert.equal(send(2n ** 53n), 2n ** 53n);
  assert.equal(send(-(2n ** 63n)), -(2n ** 63n));
  assert.equal(send(7n), 7);
  assert.throws(() => send(2n ** 63n), /loops is 9223372036854775808: expected/);
});

test('hostile lengths are refused before memory is taken', () => {
  const ladar = structOf('LadarData');
  const body = ladar.encode({ points: [{}, {}] });
  const count = new DataView(body.buffer);
  for (const [stated, problem] of [
    [-1, /LadarData\.pointNum is -1, allowed are 0 to 2160/],
    [2161, /LadarData\.pointNum is 2161, allowed are 0 to 2160/],
    [3, /LadarData\.pointNum needs 48 bytes, only 32 bytes follow/],
    [1, /LadarData is 40 bytes long by its own counts, not 56 bytes/],
  ] as const) {
    count.setInt32(20, stated, true);
    assert.throws(() => decodeData(classId('Ladar')!, body, little), problem);
    assert.throws(() => decodeData(classId('Ladar')!, body, little, { elements: true }), problem);
  }
  const map = structOf('GridMapData').encode({});
  const cells = new DataView(map.buffer);
  cells.setInt32(16, 2 ** 30, true);
  cells.setInt32(20, 2 ** 30, true);
  assert.throws(
    () => structOf('GridMapData').decode(map, true),
    /occupancy is 115292150460684\d+, allowed are 0 to 250000/,
  );
  cells.setInt32(20, -1, true);
  assert.throws(() => structOf('GridMapData').decode(map, true), /occupancy is -1, allowed/);
});

test('lists that are too long are not sent', () => {
  assert.throws(
    () => structOf('FileName').encode({ name: 'x'.repeat(128) }),
    /has 128 elements, allowed are 127: send fewer/,
  );
  assert.equal(structOf('FileName').encode({ name: 'x' }).length, 132);
  const parameter = (name: string) => structOf('Parameter').encode({ name });
  assert.doesNotThrow(() => parameter('x'.repeat(79)));
  assert.throws(() => parameter('x'.repeat(80)), /Parameter\.name has 80 bytes, allowed are 79: shorten it/);
  assert.throws(
    () => structOf('CameraData').encode({ width: 2, height: 2, depth: 8, image: new Uint8Array(3) }),
    /CameraData\.image has 3 elements, but the other fields give 4: correct one of them/,
  );
});

test('a compressed image has as many bytes as its colorFilterId', () => {
  const camera = structOf('CameraData');
  const body = camera.encode({
    mode: 41,
    width: 640,
    height: 480,
    depth: 24,
    colorFilterId: 3,
    image: bytesOfHex('ffd8ff'),
  });
  assert.deepEqual(camera.decode(body, true).image, bytesOfHex('ffd8ff'));
});

test('bytes that are not UTF-8 stay what they are', () => {
  for (const [hex, shown] of [
    ['41c3a4', 'Aä'],
    ['41e4', 'Aä'], // Latin-1
    ['c3', 'Ã'],
    ['eda080', 'í\u00a0\u0080'], // a surrogate
    ['f09f9296c0', '💖À'],
    ['efbbbf41', '\ufeffA'],
  ] as const) {
    assert.equal(shownText(textOf(bytesOfHex(hex))), shown);
    assert.deepEqual(bytesOf(textOf(bytesOfHex(hex))), bytesOfHex(hex));
  }
});

test('elements lie on the body, or are copied when its byte order or place is another', () => {
  const ladar = structOf('LadarData');
  const points = [
    { angle: -1.5, distance: 1234, type: 0x80, intensity: -1 },
    { angle: 0.25, distance: 5, type: 0, intensity: 7 },
  ];
  for (const [isLittle, shift] of [
    [true, 0],
    [true, 1],
    [false, 0],
    [false, 3],
  ] as const) {
    const body = ladar.encode({ points }, isLittle);
    const moved = new Uint8Array(body.length + 4).subarray(shift, shift + body.length);
    moved.set(body);
    const view = ladar.decode(moved, isLittle, { elements: true }).points as Elements<(typeof points)[0]>;
    assert.equal(view.length, 2);
    points.forEach((point, i) => {
      const at = i * view.step4;
      assert.equal(view.f32[at + view.index.angle], point.angle);
      assert.equal(view.i32[at + view.index.distance], point.distance);
      assert.equal(view.i32[at + view.index.intensity], point.intensity);
    });
    assert.equal(view.i32.buffer === moved.buffer, isLittle && shift === 0);
    assert.deepEqual(ladar.decode(moved, isLittle).points, points, 'the body is as it was');
  }
  const scan = structOf('Scan2dData');
  const body = scan.encode({ points: [{}, { x: -9, segment: -2, intensity: 300 }] }, false);
  const view = scan.decode(body, false, { elements: true }).points as Elements;
  assert.equal(view.i32[view.step4 + view.index.x!], -9);
  assert.equal(view.i16[view.step2 + view.index.segment!], -2);
  assert.equal(view.i16[view.step2 + view.index.intensity!], 300);
});

test('structs that no typed array can show stay objects', () => {
  const list = structOf('ParameterList');
  const body = list.encode({ parameters: [{ name: 'a' }] });
  assert.equal((list.decode(body, true, { elements: true }).parameters as Fields[])[0]!.name, 'a');
});

test('what is printed is short', () => {
  assert.equal(shortFloat(Math.fround(0.1)), 0.1);
  assert.equal(shortFloat(Math.fround(16777217)), 16777216);
  const move = structOf('ChassisMoveData');
  assert.equal(text(move.decode(bytesOfHex('0000000000000000cdcccc3d'), true), move), '{"vx":0,"vy":0,"omega":0.1}');
});

test('numbers that stand for something have names', () => {
  assert.equal(valueName('CameraData.mode', 41), 'jpeg');
  assert.equal(valueName('CameraData.mode', 99), '99');
  assert.equal(valueName('GdosData.level', -125), 'error');
  assert.equal(valueName('GpsData.mode', 18), '3D, differential');
  assert.equal(valueName('ScanPoint.type', 0x90), 'invalid, reflector');
  assert.equal(valueName('ScanPoint.type', 0x81), '1, reflector');
  assert.equal(valueName('ChassisMoveData.vx', 1), undefined);
});

test('a description that is not complete is refused', () => {
  const one = (type: string, more = {}) =>
    new Struct({ name: 'New', made: '', fields: [{ name: 'x', type, ...more }] }, new Map());
  assert.throws(() => one('Missing'), /New\.x: there is no type Missing/);
  assert.throws(() => one('u8', { tail_at_most: 5 }), /New: tails\.ts lacks its lengths/);
});
