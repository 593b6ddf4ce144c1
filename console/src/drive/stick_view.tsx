// The stick of the drive page: a pad for mouse and finger; keys and a gamepad move it, too.

import { type ReadonlySignal, useSignal } from '@preact/signals';
import { useEffect, useMemo, useRef } from 'preact/hooks';
import { useConsole } from '../app/console';
import { isSlider, isText } from '../app/focus';
import { isAtRest, type StickPosition, stickAtRest } from '../tims/joystick';
import { Hands, type Place } from './hands';
import { stickText } from './stick';

const renewPeriod = 50; // ms; the worker lets the stick go after 250

interface StickProperties {
  active: boolean;
  speed: ReadonlySignal<number>; // percent of the stick's range
  endPilot: () => void;
}

// Keys, pad and gamepad write to one position, which is renewed while it is not zero.
export function Stick({ active, speed, endPilot }: StickProperties) {
  const { client } = useConsole();
  const shown = useSignal<StickPosition>(stickAtRest);
  const hands = useMemo(() => new Hands(), []);

  useEffect(() => {
    if (!active) return;
    let sentRest = true;
    const renew = () => {
      const position = hands.position(speed.peek(), gamepads());
      shown.value = client.slowLine.peek() ? stickAtRest : position;
      if (isAtRest(position) && sentRest) return;
      client.moveStick(position);
      sentRest = isAtRest(position);
    };
    const letGo = () => {
      hands.letGo();
      renew();
    };
    const hidden = () => document.hidden && letGo();
    const down = (event: KeyboardEvent) => {
      const { target } = event;
      const focus = isText(target) ? 'text' : isSlider(target) ? 'slider' : 'other';
      const effect = hands.press(event, focus);
      if (effect === 'none') return;
      renew();
      if (effect === 'end') endPilot();
      else if (focus !== 'text') event.preventDefault();
    };
    const up = (event: KeyboardEvent) => {
      hands.release(event);
      renew();
    };
    letGo(); // what was held before does not drive
    const timer = setInterval(renew, renewPeriod);
    addEventListener('keydown', down);
    addEventListener('keyup', up);
    addEventListener('blur', letGo);
    document.addEventListener('visibilitychange', hidden);
    return () => {
      letGo();
      clearInterval(timer);
      removeEventListener('keydown', down);
      removeEventListener('keyup', up);
      removeEventListener('blur', letGo);
      document.removeEventListener('visibilitychange', hidden);
    };
  }, [active]);

  return (
    <>
      <Pad active={active} position={shown.value} hands={hands} />
      {active && <p class="small">{stickText(shown.value)}</p>}
      {active && client.slowLine.value && (
        <p class="notice bad" role="alert">
          The line to the router is slow: it answers later than after 0.3 s. The stick rests until it is faster.
        </p>
      )}
    </>
  );
}

// All windows see the same gamepads: they belong to the one that has the focus.
function gamepads(): readonly (Gamepad | null)[] {
  return document.hasFocus() && !document.hidden ? (navigator.getGamepads?.() ?? []) : [];
}

interface PadProperties {
  active: boolean;
  position: StickPosition;
  hands: Hands;
}

function Pad({ active, position, hands }: PadProperties) {
  const pad = useRef<HTMLDivElement>(null);
  const placeOf = (event: PointerEvent): Place | undefined => {
    const box = pad.current?.getBoundingClientRect();
    return (
      box && {
        right: (2 * (event.clientX - box.left)) / box.width - 1,
        up: 1 - (2 * (event.clientY - box.top)) / box.height,
      }
    );
  };
  const lift = () => hands.lift();
  return (
    <div
      ref={pad}
      class={`pad ${active ? '' : 'inactive'}`}
      role="application"
      aria-label="Stick: hold to drive"
      onPointerDown={(event) => {
        const place = placeOf(event);
        if (!active || event.button !== 0 || place === undefined) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        hands.touch(place);
      }}
      onPointerMove={(event) => {
        // A button that is released while another one is pressed is no pointerup.
        const place = (event.buttons & 1) === 1 ? placeOf(event) : undefined;
        if (place === undefined) hands.lift();
        else hands.drag(place);
      }}
      onPointerUp={lift}
      onPointerCancel={lift}
      onLostPointerCapture={lift}
      onContextMenu={(event) => event.preventDefault()}
    >
      <span class="knob" style={{ left: `${50 + position.y / 2}%`, top: `${50 - position.x / 2}%` }} />
    </div>
  );
}
