import assert from 'node:assert/strict';
import { test } from 'node:test';
import { stickAtRest } from '../tims/joystick';
import { isAnyOtherKey, stickKey, stickOfGamepad, stickOfKeys, stickOfPad } from './stick';

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

test('a gamepad that does not rest exactly does not drive', () => {
  assert.deepEqual(stickOfGamepad([0.1, -0.1, 0.1], 100), stickAtRest);
  assert.deepEqual(stickOfGamepad([0.5, -1, 0], 100), { x: 100, y: 50, z: 0, buttons: 0 });
  assert.deepEqual(stickOfGamepad([], 100), stickAtRest);
});
