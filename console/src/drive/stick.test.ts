import assert from 'node:assert/strict';
import { test } from 'node:test';
import { stickAtRest } from '../tims/joystick';
import { isAnyOtherKey, stickKey, stickOfGamepad, stickOfKeys, stickOfPad, stickText } from './stick';

test('keys add up, and opposite ones cancel', () => {
  assert.deepEqual(stickOfKeys(new Set(['ArrowUp', 'ArrowLeft']), 30), { x: 30, y: -30, z: 0, buttons: 0 });
  assert.deepEqual(stickOfKeys(new Set(['ArrowUp', 's']), 30), stickAtRest);
  assert.deepEqual(stickOfKeys(new Set(['w', 'ArrowUp']), 100), { x: 100, y: 0, z: 0, buttons: 0 });
  assert.deepEqual(stickOfKeys(new Set(['x']), 100), stickAtRest);
});

test('the block of digits, capital letters, and the buttons', () => {
  assert.equal(stickKey({ key: '8', code: 'Numpad8' }), 'ArrowUp');
  assert.equal(stickKey({ key: '8', code: 'Digit8' }), undefined);
  assert.equal(stickKey({ key: 'W', code: 'KeyW' }), 'w');
  assert.equal(stickKey({ key: 'F4', code: 'F4' }), 'F4');
  assert.equal(stickKey({ key: 'F5', code: 'F5' }), undefined);
  assert.deepEqual(stickOfKeys(new Set(['F1', 'F3']), 30), { x: 0, y: 0, z: 0, buttons: 5 });
});

test('any other key takes the pilot away; keys that move about in the page do not', () => {
  for (const key of ['x', '?', '9', 'ä', 'Escape', 'Delete']) assert(isAnyOtherKey({ key, code: '' }), key);
  for (const key of ['w', 'ArrowUp', ' ', 'F1', 'F9', 'Tab', 'Shift', 'Enter', 'Control'])
    assert(!isAnyOtherKey({ key, code: '' }), key);
  assert(!isAnyOtherKey({ key: '5', code: 'Numpad5' }));
});

test('the pad rests in its middle and ends at its edge', () => {
  assert.deepEqual(stickOfPad(0.05, 0.05, 100), stickAtRest);
  assert.deepEqual(stickOfPad(0, 1, 50), { x: 50, y: 0, z: 0, buttons: 0 });
  assert.deepEqual(stickOfPad(3, 0, 50), { x: 0, y: 50, z: 0, buttons: 0 });
});

test('Shift makes sideways of what turns', () => {
  assert.equal(stickKey({ key: 'Shift', code: 'ShiftLeft' }), 'Shift');
  assert.deepEqual(stickOfKeys(new Set(['Shift', 'ArrowUp', 'a']), 30), { x: 30, y: 0, z: -30, buttons: 0 });
  assert.deepEqual(stickOfKeys(new Set(['Shift', 'ArrowRight', 'q']), 30), stickAtRest);
  assert.deepEqual(stickOfKeys(new Set(['Shift']), 30), stickAtRest);
});

test('a gamepad that does not rest exactly does not drive', () => {
  const held = (axes: number[], buttons: boolean[] = []) =>
    stickOfGamepad({ axes, buttons: buttons.map((pressed) => ({ pressed })) }, 100);
  assert.deepEqual(held([0.1, -0.1, 0.1]), stickAtRest);
  assert.deepEqual(held([0.5, -1, 0]), { x: 100, y: 50, z: 0, buttons: 0 });
  assert.deepEqual(held([0, 0, -0.3, 1]), { x: 0, y: 0, z: -30, buttons: 0 });
  assert.deepEqual(held([]), stickAtRest);
  assert.equal(held([], [true, false, false, true, true]).buttons, 9, 'its first four buttons');
});

test('the stick in words', () => {
  assert.equal(stickText(stickAtRest), 'forward 0 %, right 0 %, sideways 0 %');
  assert.equal(stickText({ x: 30, y: -10, z: 5, buttons: 5 }), 'forward 30 %, right −10 %, sideways 5 %, button 1, 3');
});
