// The canvas of a map: drawn once a frame when something has changed; moved by mouse, touch and keys.

import { useEffect, useRef } from 'preact/hooks';
import { isDark } from '../ui/theme';
import { measured, type Spot } from './actions';
import { mapColours } from './colours';
import { type Layers, paintMap, paintWaypoints } from './paint';
import { PointBuffer } from './points';
import type { Plan, RobotScene } from './scene';
import { Steps } from './steps';
import { headingTo, type Point, panned, type Size, toScreen, toWorld, type View, viewOf, zoomed } from './transform';
import { Waypoints } from './waypoints';

export type Centre = 'world' | 'chase' | 'robot';

export interface MapModel {
  view: View;
  isPlaced: boolean; // the view has been fitted or moved
  scenes: Map<number, RobotScene>;
  followed: number | undefined;
  centre: Centre;
  layers: Layers;
  // A place that is being chosen.
  draft: Spot | undefined;
  waypoints: Waypoints;
  steps: Steps;
  background: Plan[]; // the lowest first
  changed: boolean;
  moved?: () => void; // by hand, so that it follows nobody any more
}

export function newMapModel(layers: Layers): MapModel {
  return {
    view: { centre: { x: 0, y: 0 }, scale: 0.03, up: 0 },
    isPlaced: false,
    scenes: new Map(),
    followed: undefined,
    centre: 'chase',
    layers,
    draft: undefined,
    waypoints: new Waypoints(),
    steps: new Steps(),
    background: [],
    changed: true,
  };
}

interface Properties {
  model: MapModel;
  label: string;
  // While a tool is chosen: a press sets the place, dragging the heading.
  choose: ((spot: Spot) => void) | undefined;
}

const keyStep = 40; // pixels
const zoomStep = 1.25;
const turnStep = Math.PI / 18;
const zoomDrag = 150; // pixels that are dragged up for a factor of e
const rightButton = 2; // of PointerEvent.buttons
const bothButtons = 3;

export function MapCanvas({ model, label, choose }: Properties) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const chooser = useRef(choose);
  chooser.current = choose;
  isDark(); // drawn again in other colours
  useEffect(() => {
    const element = canvas.current;
    if (element === null) return;
    const size: Size = { width: 0, height: 0 };
    const observer = new ResizeObserver(([entry]) => {
      if (entry === undefined) return;
      size.width = entry.contentRect.width;
      size.height = entry.contentRect.height;
      element.width = Math.round(size.width * devicePixelRatio);
      element.height = Math.round(size.height * devicePixelRatio);
      model.changed = true;
    });
    observer.observe(element);
    const endDrawing = drawEachFrame(element, model, size);
    const endGestures = gestures(element, model, size, () => chooser.current);
    return () => {
      observer.disconnect();
      endDrawing();
      endGestures();
    };
  }, [model]);
  useEffect(() => {
    if (choose === undefined) model.draft = undefined;
    model.changed = true;
  });
  return (
    <canvas
      ref={canvas}
      class={`map ${choose === undefined ? '' : 'choosing'}`}
      tabIndex={0}
      role="img"
      aria-label={label}
      onKeyDown={(event) => {
        const isChosen = choose !== undefined && chooseByKey(model, event, choose);
        if (isChosen || moveByKey(model, event.key)) event.preventDefault();
      }}
    />
  );
}

function drawEachFrame(element: HTMLCanvasElement, model: MapModel, size: Size): () => void {
  const context = element.getContext('2d', { alpha: false });
  if (context === null) return () => {};
  const points = new PointBuffer();
  let frame = 0;
  let drawnAt = 0;
  const draw = (now: number) => {
    frame = requestAnimationFrame(draw);
    // Once a second, so that what is old turns grey.
    if ((!model.changed && now < drawnAt + 1000) || size.width === 0) return;
    model.changed = false;
    drawnAt = now;
    follow(model, size);
    element.dataset.scale = `${model.view.scale}`; // pixels a mm
    const colours = mapColours();
    const drawing = { context, points, size, ratio: devicePixelRatio, view: model.view, colours };
    paintMap(drawing, [...model.scenes.values()], model.layers, now, model.background);
    paintWaypoints(drawing, model.waypoints.list.value);
    if (model.draft !== undefined) paintDraft(context, model, size, colours.goal);
  };
  frame = requestAnimationFrame(draw);
  return () => cancelAnimationFrame(frame);
}

// Fits the robots into the view at the start, and keeps the followed one in its middle.
function follow(model: MapModel, size: Size): void {
  const poses = [...model.scenes.values()].flatMap(({ pose }) => (pose === undefined ? [] : [pose]));
  if (!model.isPlaced && poses.length > 0) {
    const view = viewOf(poses, size);
    if (view !== undefined) model.view = { ...view, scale: Math.min(view.scale, 0.06) };
    model.isPlaced = true;
  }
  const pose = model.followed === undefined ? undefined : model.scenes.get(model.followed)?.pose;
  if (pose === undefined || model.centre === 'world') {
    model.view = { ...model.view, up: 0 };
    return;
  }
  model.view = { ...model.view, centre: { x: pose.x, y: pose.y }, up: model.centre === 'robot' ? pose.rho : 0 };
}

function paintDraft(context: CanvasRenderingContext2D, { view, draft }: MapModel, size: Size, colour: string): void {
  if (draft === undefined) return;
  const at = toScreen(view, size, draft);
  const angle = draft.rho - view.up;
  context.strokeStyle = colour;
  context.lineWidth = 3;
  context.beginPath();
  context.arc(at.x, at.y, 7, 0, 2 * Math.PI);
  context.moveTo(at.x, at.y);
  context.lineTo(at.x + 36 * Math.sin(angle), at.y - 36 * Math.cos(angle));
  context.stroke();
  context.fillStyle = colour;
  context.font = '600 13px system-ui, sans-serif';
  context.textAlign = 'left';
  context.fillText(measured(draft), at.x + 12, at.y + 18);
}

export function moveByKey(model: MapModel, key: string): boolean {
  const moves: Record<string, () => void> = {
    '+': () => zoom(model, zoomStep),
    '-': () => zoom(model, 1 / zoomStep),
    PageUp: () => zoom(model, zoomStep),
    PageDown: () => zoom(model, 1 / zoomStep),
    Home: () => {
      model.isPlaced = false;
      model.changed = true;
    },
  };
  const arrow = arrows[key];
  if (arrow !== undefined) pan(model, -arrow[0] * keyStep, -arrow[1] * keyStep);
  const move = moves[key];
  move?.();
  return move !== undefined || arrow !== undefined;
}

// Enter begins to choose a place in the middle of the map, the arrows move it, with Shift its end, G and H turn it, and
// Enter takes it.
function chooseByKey(model: MapModel, { key, shiftKey }: KeyboardEvent, choose: (spot: Spot) => void): boolean {
  const { view, draft } = model;
  if (key === 'Enter') {
    model.draft = draft === undefined ? { ...view.centre, rho: view.up, end: view.centre } : undefined;
    if (draft !== undefined) choose(draft);
  } else if (draft === undefined) return false;
  else if (/^(g|PageUp)$/i.test(key)) model.draft = { ...draft, rho: draft.rho - turnStep };
  else if (/^(h|PageDown)$/i.test(key)) model.draft = { ...draft, rho: draft.rho + turnStep };
  else {
    const [right, down] = arrows[key] ?? [];
    if (right === undefined || down === undefined) return false;
    const { centre } = panned(view, -right * keyStep, -down * keyStep);
    const moved = ({ x, y }: Point) => ({ x: x + centre.x - view.centre.x, y: y + centre.y - view.centre.y });
    const end = moved(draft.end);
    model.draft = shiftKey ? { ...draft, end, rho: headingTo(draft, end) } : { ...draft, ...moved(draft), end };
  }
  model.changed = true;
  return true;
}

const arrows: Record<string, [right: number, down: number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

export function zoom(model: MapModel, factor: number): void {
  model.view = zoomed(model.view, { width: 0, height: 0 }, { x: 0, y: 0 }, factor);
  model.isPlaced = true;
  model.changed = true;
}

// A map that is moved by hand no longer follows.
function pan(model: MapModel, right: number, down: number): void {
  model.view = panned(model.view, right, down);
  model.centre = 'world';
  model.isPlaced = true;
  model.changed = true;
  model.moved?.();
}

// One pointer moves the map, or sets the pose of the chosen tool; two pinch it. Of a mouse, the right button zooms about
// where it was pressed: up is nearer. Both buttons bring that place into the middle.
function gestures(
  element: HTMLCanvasElement,
  model: MapModel,
  size: Size,
  tool: () => ((spot: Spot) => void) | undefined,
): () => void {
  const pointers = new Map<number, Point>();
  let start: Point | undefined;
  let zoomCentre: Point | undefined;
  const at = ({ offsetX, offsetY }: PointerEvent): Point => ({ x: offsetX, y: offsetY });

  const letGoOfTool = () => {
    start = undefined;
    model.draft = undefined;
  };
  // True: it was one of the mouse's own gestures.
  const moveByMouse = ({ button, buttons, movementY, offsetX, offsetY }: PointerEvent): boolean => {
    if (buttons === bothButtons) {
      if (button < 0) return true; // it was pressed before
      letGoOfTool();
      zoomCentre = undefined;
      pan(model, size.width / 2 - offsetX, size.height / 2 - offsetY);
    } else if (buttons === rightButton && zoomCentre !== undefined) {
      model.view = zoomed(model.view, size, zoomCentre, Math.exp(-movementY / zoomDrag));
      model.isPlaced = true;
      model.changed = true;
    } else return false;
    return true;
  };

  const down = (event: PointerEvent) => {
    element.setPointerCapture(event.pointerId);
    if (event.buttons === rightButton) {
      zoomCentre = at(event);
      return;
    }
    pointers.set(event.pointerId, at(event));
    if (tool() === undefined || pointers.size > 1) {
      letGoOfTool();
      return;
    }
    start = at(event);
    const place = toWorld(model.view, size, start);
    model.draft = { ...place, rho: model.view.up, end: place };
    model.changed = true;
  };
  const move = (event: PointerEvent) => {
    if (moveByMouse(event)) {
      if (pointers.has(event.pointerId)) pointers.set(event.pointerId, at(event));
      return;
    }
    const before = pointers.get(event.pointerId);
    if (before === undefined) return;
    const now = at(event);
    pointers.set(event.pointerId, now);
    if (start !== undefined && model.draft !== undefined) {
      const target = toWorld(model.view, size, now);
      if (Math.hypot(now.x - start.x, now.y - start.y) > 8)
        model.draft = { ...model.draft, rho: headingTo(model.draft, target), end: target };
      model.changed = true;
      return;
    }
    const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
    if (other !== undefined) {
      const factor = distance(now, other) / Math.max(1, distance(before, other));
      model.view = zoomed(model.view, size, { x: (now.x + other.x) / 2, y: (now.y + other.y) / 2 }, factor);
      model.isPlaced = true;
      model.changed = true;
    } else {
      pan(model, now.x - before.x, now.y - before.y);
    }
  };
  const up = (event: PointerEvent) => {
    pointers.delete(event.pointerId);
    zoomCentre = undefined;
    if (start === undefined || model.draft === undefined) return;
    start = undefined;
    const spot = model.draft;
    model.draft = undefined;
    model.changed = true;
    if (event.type === 'pointerup') tool()?.(spot);
  };
  const wheel = (event: WheelEvent) => {
    event.preventDefault();
    model.changed = true;
    if (model.draft !== undefined) {
      model.draft = { ...model.draft, rho: model.draft.rho + Math.sign(event.deltaY) * turnStep };
      return;
    }
    const point = { x: event.offsetX, y: event.offsetY };
    model.view = zoomed(model.view, size, point, Math.exp(-event.deltaY / 400));
    model.isPlaced = true;
  };
  const listeners: [string, (event: never) => void][] = [
    ['pointerdown', down],
    ['pointermove', move],
    ['pointerup', up],
    ['pointercancel', up],
    ['wheel', wheel],
    ['contextmenu', (event: Event) => event.preventDefault()], // the right button zooms
  ];
  for (const [type, listener] of listeners)
    element.addEventListener(type, listener as EventListener, { passive: false });
  return () => {
    for (const [type, listener] of listeners) element.removeEventListener(type, listener as EventListener);
  };
}

const distance = (a: Point, b: Point) => Math.hypot(a.x - b.x, a.y - b.y);
