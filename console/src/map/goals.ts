// The goals that somebody leads a robot to, one after the other, like the original's PositionNavi: where the next one
// is, how far it is, and how far it is to the last one.

import { computed, effect, signal } from '@preact/signals';
import { headingTo, type Point, type Pose } from './transform';

export interface UtmPlace {
  zone: number;
  band: number; // index into `bands`
  easting: number; // mm
  northing: number; // mm
}

const bands = 'ABCDEFGHJKLMNPQRSTUVWXYZ';
const number = '(\\d+(?:\\.\\d+)?)\\s*m?';
const line = new RegExp(`^(\\d{1,2})\\s*([A-HJ-NP-Z])\\s+${number}\\s*E\\s+${number}\\s*N$`, 'i');
const goalsMax = 1000;

// A line a goal: "32U 550000.00m E 5800000.00m N"; "#" begins a comment. Throws which line is none.
export function readUtmPlaces(text: string): UtmPlace[] {
  const places: UtmPlace[] = [];
  for (const [i, raw] of text.split(/\r?\n/).entries()) {
    const content = raw.trim();
    if (content === '' || content.startsWith('#')) continue;
    const [, zone, band, easting, northing] = line.exec(content) ?? [];
    if (zone === undefined || band === undefined || Number(zone) < 1 || Number(zone) > 60)
      throw new Error(`line ${i + 1} is no place like “32U 550000.00m E 5800000.00m N”: ${content}`);
    places.push({
      zone: Number(zone),
      band: bands.indexOf(band.toUpperCase()),
      easting: Math.round(1000 * Number(easting)),
      northing: Math.round(1000 * Number(northing)),
    });
  }
  if (places.length === 0) throw new Error('the file has no places');
  if (places.length > goalsMax) throw new Error(`the file has ${places.length} places; ${goalsMax} are possible`);
  return places;
}

export class Goals {
  readonly list = signal<Point[]>([]);
  readonly index = signal(0);
  readonly turnover = signal(2000); // mm: from here on the next goal counts
  // There is one to go on to.
  readonly isUnderWay = computed(() => this.index.value + 1 < this.list.value.length);

  set(list: Point[]): void {
    this.list.value = list;
    this.index.value = 0;
  }

  step(by: 1 | -1): void {
    this.index.value = Math.max(0, Math.min(this.list.value.length - 1, this.index.value + by));
  }

  get present(): Point | undefined {
    return this.list.value[this.index.value];
  }

  // The robot is there: goes on to the next goal when this one is near; the last one stays.
  pass(pose: Point): void {
    const goal = this.present;
    if (goal !== undefined && distance(pose, goal) < this.turnover.value) this.step(1);
  }

  // Undefined: there is no goal.
  from(pose: Pose): { distance: number; direction: number; inAll: number } | undefined {
    const goal = this.present;
    if (goal === undefined) return undefined;
    const first = distance(pose, goal);
    const rest = this.list.value.slice(this.index.value);
    const inAll = rest.slice(1).reduce((sum, point, i) => sum + distance(rest[i] ?? point, point), first);
    return { distance: first, direction: headingTo(pose, goal), inAll };
  }
}

// Says where a robot is until the function that it returns is called.
export type FollowPosition = (system: number, take: (pose: Point) => void) => () => void;

// Of each robot, while the page lives. As long as there is a goal to go on to, its robot is followed, whatever is shown.
export class GoalLists {
  private readonly lists = new Map<number, Goals>();

  constructor(private readonly follow: FollowPosition) {}

  of(system: number): Goals {
    const known = this.lists.get(system);
    if (known !== undefined) return known;
    const goals = new Goals();
    this.lists.set(system, goals);
    effect(() => (goals.isUnderWay.value ? this.follow(system, (pose) => goals.pass(pose)) : undefined));
    return goals;
  }
}

const distance = (a: Point, b: Point) => Math.hypot(a.x - b.x, a.y - b.y);
