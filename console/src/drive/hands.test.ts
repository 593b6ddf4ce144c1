import assert from 'node:assert/strict';
import { test } from 'node:test';
import { stickAtRest } from '../tims/joystick';
import { type Focus, type GamepadState, Hands, type PressedKey } from './hands';

const speed = 50;
const plain = { code: '', repeat: false, ctrlKey: false, altKey: false, metaKey: false };
const press = (hands: Hands, key: string, more: Partial<PressedKey> = {}, focus: Focus = 'other') =>
  hands.press({ ...plain, key, ...more }, focus);
const gamepad = (x: number, index = 0): GamepadState => ({ index, connected: true, axes: [0, -x, 0], buttons: [] });
const forward = { x: 50, y: 0, z: 0, buttons: 0 };

test('keys drive while they are held; Space lets go, and what is still held then does not drive', () => {
  const hands = new Hands();
  assert.equal(press(hands, 'ArrowUp'), 'hold');
  assert.deepEqual(hands.position(speed, []), forward);
  assert.equal(press(hands, ' '), 'stop');
  assert.deepEqual(hands.position(speed, []), stickAtRest);
  assert.equal(press(hands, 'ArrowUp', { repeat: true }), 'hold', 'the page must not scroll');
  assert.deepEqual(hands.position(speed, []), stickAtRest, 'a repetition is no new press');
  hands.release({ key: 'ArrowUp', code: '' });
  press(hands, 'ArrowUp');
  assert.deepEqual(hands.position(speed, []), forward);
  hands.release({ key: 'ArrowUp', code: '' });
  assert.deepEqual(hands.position(speed, []), stickAtRest);
});

test('Space stops whatever has the focus, also with Ctrl', () => {
  for (const focus of ['text', 'slider', 'other'] as const)
    for (const ctrlKey of [false, true]) {
      const hands = new Hands();
      press(hands, 'w');
      assert.equal(press(hands, ' ', { ctrlKey }, focus), 'stop', focus);
      assert.deepEqual(hands.position(speed, []), stickAtRest, focus);
    }
});

test('a slider keeps the keys that move it, a text all others', () => {
  const hands = new Hands();
  assert.equal(press(hands, 'ArrowUp', {}, 'slider'), 'none');
  assert.equal(press(hands, 'End', {}, 'slider'), 'none');
  assert.equal(press(hands, 'w', {}, 'text'), 'none');
  assert.deepEqual(hands.position(speed, []), stickAtRest);
  assert.equal(press(hands, 'w', {}, 'slider'), 'hold');
  assert.equal(press(hands, 'x', {}, 'slider'), 'end');
});

test('any other key ends the pilot, once; digits choose one, and Alt and Ctrl belong to the browser', () => {
  const hands = new Hands();
  press(hands, 'ArrowUp');
  assert.equal(press(hands, 'x'), 'end');
  assert.deepEqual(hands.position(speed, []), stickAtRest);
  assert.equal(press(hands, 'x', { repeat: true }), 'none');
  assert.equal(press(hands, '2', { code: 'Digit2' }), 'none');
  assert.equal(press(hands, 'x', { altKey: true }), 'none');
  assert.equal(press(hands, 'w', { ctrlKey: true }), 'none');
  assert.equal(press(hands, 'w', { metaKey: true }), 'none');
});

test('a finger that was let go must touch the pad again', () => {
  const hands = new Hands();
  hands.drag({ right: 0, up: 1 });
  assert.deepEqual(hands.position(speed, []), stickAtRest, 'it only passes over it');
  hands.touch({ right: 0, up: 0.5 });
  hands.drag({ right: 0, up: 1 });
  assert.deepEqual(hands.position(speed, []), forward);
  hands.letGo();
  hands.drag({ right: 0, up: 1 });
  assert.deepEqual(hands.position(speed, []), stickAtRest);
  hands.touch({ right: 0, up: 1 });
  hands.lift();
  assert.deepEqual(hands.position(speed, []), stickAtRest);
});

test('a gamepad drives after it has rested, at the beginning and when all was let go', () => {
  const hands = new Hands();
  assert.deepEqual(hands.position(speed, [gamepad(1)]), stickAtRest, 'it was held before');
  hands.position(speed, [gamepad(0.05)]);
  assert.deepEqual(hands.position(speed, [null, gamepad(1)]), forward);
  press(hands, ' ');
  assert.deepEqual(hands.position(speed, [gamepad(1)]), stickAtRest);
  assert.deepEqual(hands.position(speed, [gamepad(0.5)]), stickAtRest);
  hands.position(speed, [gamepad(0)]);
  assert.deepEqual(hands.position(speed, [gamepad(1)]), forward);
});

test('a gamepad must rest after another window has had the focus, when it was away, and when another takes its place', () => {
  for (const between of [[], [{ ...gamepad(1), connected: false }], [gamepad(1, 1)]]) {
    const hands = new Hands();
    hands.position(speed, [gamepad(0)]);
    assert.deepEqual(hands.position(speed, [gamepad(1)]), forward);
    assert.deepEqual(hands.position(speed, between), stickAtRest);
    assert.deepEqual(hands.position(speed, [gamepad(1)]), stickAtRest);
  }
});

test('a button of a gamepad that is held is no rest', () => {
  const hands = new Hands();
  const pressed = { ...gamepad(0), buttons: [{ pressed: true }] };
  assert.equal(hands.position(speed, [pressed]).buttons, 0);
  hands.position(speed, [gamepad(0)]);
  assert.equal(hands.position(speed, [pressed]).buttons, 1);
});
