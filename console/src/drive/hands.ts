// What holds the stick of the drive page: keys, a finger on the pad, a gamepad.
//
// Whoever has let go, by Space or by leaving the page, must take hold anew: a key is pressed again, the pad is touched
// again, and the stick of a gamepad must have been in its middle.

import { isAtRest, type StickPosition, stickAtRest } from '../tims/joystick';
import { isAnyOtherKey, stickKey, stickOfGamepad, stickOfKeys, stickOfPad } from './stick';

// On the pad: -1 to 1, up is forward.
export interface Place {
  right: number;
  up: number;
}

export interface PressedKey {
  key: string;
  code: string;
  repeat: boolean; // it is held, and the browser says so again
  ctrlKey: boolean;
  altKey: boolean;
  metaKey: boolean;
}

// Of what a Gamepad has.
export interface GamepadState {
  index: number;
  connected: boolean;
  axes: readonly number[];
  buttons: readonly { pressed: boolean }[];
}

// What has the focus: it takes all that is typed, it is moved by arrows, or neither.
export type Focus = 'text' | 'slider' | 'other';

// 'end': also takes the pilot away. 'none': the key is none of the stick's.
export type KeyEffect = 'hold' | 'stop' | 'end' | 'none';

const sliderKeys = ['ArrowUp', 'ArrowDown', 'ArrowLeft', 'ArrowRight', 'Home', 'End', 'PageUp', 'PageDown'];

export class Hands {
  private readonly keys = new Set<string>();
  private finger: Place | undefined;
  private rested: number | undefined; // the gamepad that has rested since all was let go

  // Space stops whatever has the focus.
  press(event: PressedKey, focus: Focus): KeyEffect {
    if (event.key === ' ') {
      this.letGo();
      return 'stop';
    }
    if (focus === 'text' || event.ctrlKey || event.metaKey) return 'none';
    if (focus === 'slider' && sliderKeys.includes(event.key)) return 'none';
    const key = stickKey(event);
    if (key !== undefined) {
      if (!event.repeat) this.keys.add(key);
      return 'hold';
    }
    const isPilot = /^Digit[1-9]$/.test(event.code); // chooses another one
    if (isPilot || event.altKey || event.repeat || !isAnyOtherKey(event)) return 'none';
    this.letGo();
    return 'end';
  }

  release(event: { key: string; code: string }): void {
    const key = stickKey(event);
    if (key !== undefined) this.keys.delete(key);
  }

  touch(place: Place): void {
    this.finger = place;
  }

  // A finger that has been let go stays without effect until it touches the pad again.
  drag(place: Place): void {
    if (this.finger !== undefined) this.finger = place;
  }

  lift(): void {
    this.finger = undefined;
  }

  letGo(): void {
    this.keys.clear();
    this.finger = undefined;
    this.rested = undefined;
  }

  // `gamepads`: as the browser lists them; empty when another page or program has the focus, since all windows see
  // the same gamepad. `speed`: percent of the stick's range.
  position(speed: number, gamepads: readonly (GamepadState | null)[]): StickPosition {
    const gamepad = gamepads.find((each) => each?.connected) ?? undefined;
    const held = gamepad === undefined ? stickAtRest : stickOfGamepad(gamepad, speed);
    if (gamepad?.index !== this.rested) this.rested = isAtRest(held) ? gamepad?.index : undefined;
    if (this.finger !== undefined) return stickOfPad(this.finger.right, this.finger.up, speed);
    const byKeys = stickOfKeys(this.keys, speed);
    if (!isAtRest(byKeys)) return byKeys;
    return this.rested === undefined ? stickAtRest : held;
  }
}
