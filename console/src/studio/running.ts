// What the components of the fleet do now: the values of their parameters, and who listens to them.

import { type Signal, signal } from '@preact/signals';
import { decodeMessage, decodeStruct } from '../codec/catalogue';
import { componentOf, type Widths } from '../tims/address';
import type { Client } from '../tims/client';
import { types } from '../tims/header';
import { type Parameter, valueText } from '../ui/parameters';

export type RunningValues = ReadonlyMap<string, string>;

export class Running {
  // By address. Empty: it does not answer.
  readonly values: Signal<ReadonlyMap<number, RunningValues>> = signal(new Map());
  // The components that get data of a component.
  readonly listeners: Signal<ReadonlyMap<number, ReadonlySet<number>>> = signal(new Map());

  constructor(private readonly client: Client) {}

  async loadValues(components: { address: number; classId: number }[]): Promise<void> {
    const loaded = await Promise.all(
      components.map(async ({ address, classId }) => [address, await this.valuesOf(address, classId)] as const),
    );
    this.values.value = new Map([...this.values.value, ...loaded]);
  }

  async loadListeners(components: { address: number }[], widths: Widths): Promise<void> {
    const loaded = await Promise.all(
      components.map(async ({ address }) => [address, await this.listenersOf(address, widths)] as const),
    );
    this.listeners.value = new Map(loaded);
  }

  private async valuesOf(address: number, classId: number): Promise<RunningValues> {
    try {
      const answer = await this.client.call(address, types.getParam);
      if (answer.type !== types.param) return new Map();
      const list = decodeMessage(classId, types.param, answer.body, answer.flags) as { parameters: Parameter[] };
      return new Map(list.parameters.map((parameter) => [parameter.name, valueText(parameter)]));
    } catch {
      return new Map();
    }
  }

  private async listenersOf(address: number, widths: Widths): Promise<ReadonlySet<number>> {
    try {
      const answer = await this.client.call(address, types.getListeners);
      if (answer.type !== -types.getListeners) return new Set();
      const { listeners } = decodeStruct('ListenersData', answer.body, answer.flags);
      return new Set(listeners.map(({ mailbox }) => componentOf(mailbox, widths)));
    } catch {
      return new Set();
    }
  }
}
