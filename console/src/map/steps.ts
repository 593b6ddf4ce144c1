// What was done on the map and can be taken back, the last one first.

import { computed, signal } from '@preact/signals';

export interface Step {
  title: string;
  undo: () => Promise<string>; // says what it has done; throws why it cannot
}

const stepsMax = 50;

export class Steps {
  private readonly steps = signal<Step[]>([]);
  readonly last = computed(() => this.steps.value.at(-1));

  add(step: Step): void {
    this.steps.value = [...this.steps.value, step].slice(-stepsMax);
  }

  // A step that cannot be taken back is not tried again: it would stand before those that can.
  async undo(): Promise<string> {
    const step = this.steps.value.at(-1);
    if (step === undefined) return '';
    this.steps.value = this.steps.value.slice(0, -1);
    return step.undo();
  }
}
