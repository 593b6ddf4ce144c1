// The waypoints that somebody sets on the map before they are sent: a list that can be taken back step by step.

import { signal } from '@preact/signals';
import type { Console } from '../app/console';
import type { Waypoint2d } from '../codec/messages';
import { command } from '../model/commands';
import type { Component } from '../model/fleet';

export interface Waypoint {
  x: number; // mm
  y: number;
  backward: boolean; // the vehicle comes to it backward
}

const speed = 500; // mm/s

export class Waypoints {
  readonly list = signal<Waypoint[]>([]);
  private past: Waypoint[][] = [];

  add(point: Waypoint): void {
    this.change([...this.list.value, point]);
  }

  remove(index: number): void {
    this.change(this.list.value.filter((_, i) => i !== index));
  }

  clear(): void {
    this.change([]);
  }

  undo(): void {
    const before = this.past.pop();
    if (before !== undefined) this.list.value = before;
  }

  get canUndo(): boolean {
    return this.past.length > 0;
  }

  // The path is made of them at once. An empty list ends the path.
  async send(console: Console, path: Component): Promise<void> {
    const waypoints = this.list.value.map(({ x, y, backward }) => ({
      ...({} as Waypoint2d),
      x,
      y,
      speed: backward ? -speed : speed,
    }));
    await console.leases.during(path.system, async () => {
      await command(console.client, path, 'Path.SET_RDDF', { waypoints });
      if (waypoints.length > 0) await command(console.client, path, 'Path.MAKE');
    });
  }

  private change(next: Waypoint[]): void {
    this.past.push(this.list.value);
    this.list.value = next;
  }
}
