// The pilot that a page drives with: from when it is chosen until the page is left, also when it is left meanwhile.

import { type ReadonlySignal, signal } from '@preact/signals';
import type { StickPilot } from './drive';

// What it does at the robot.
interface Acts {
  begin: (pilot: StickPilot, over: boolean) => Promise<void>;
  end: (pilot: StickPilot) => Promise<void>;
}

export class Driver {
  private readonly drivenSignal = signal<StickPilot | undefined>(undefined);
  private isLeft = false;

  constructor(private readonly acts: Acts) {}

  get driven(): ReadonlySignal<StickPilot | undefined> {
    return this.drivenSignal;
  }

  // `over`: take the robot from whoever drives it. Throws what hindered it.
  async begin(pilot: StickPilot, over: boolean): Promise<void> {
    await this.end();
    if (this.isLeft) return;
    await this.acts.begin(pilot, over);
    if (this.isLeft) await this.acts.end(pilot);
    else this.drivenSignal.value = pilot;
  }

  async end(): Promise<void> {
    const pilot = this.drivenSignal.peek();
    this.lose();
    if (pilot !== undefined) await this.acts.end(pilot);
  }

  // Something else has ended it.
  lose(): void {
    this.drivenSignal.value = undefined;
  }

  // The page is gone: nobody is left to be told what fails.
  leave(): void {
    this.isLeft = true;
    this.end().catch(() => {});
  }
}
