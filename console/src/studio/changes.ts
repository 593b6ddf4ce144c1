// Changes that are under way on the hosts, whoever made them, and how they ended.

import { computed, type Signal, signal } from '@preact/signals';
import { type ApplyTools, applyChange, type Change, changesUnderWay, confirmChange, type Ended, endOf } from './apply';
import type { FileKey } from './draft';
import type { HostState } from './protocol';

type Texts = [FileKey, string | null][];

export class Changes {
  readonly states: Signal<ReadonlyMap<string, HostState>> = signal(new Map());
  readonly statesAt = signal(0); // performance.now()
  readonly ended: Signal<Ended | undefined> = signal(undefined);
  readonly underWay = computed(() => changesUnderWay(this.states.value.values()));
  private followed = new Map<string, string[]>(); // their hosts
  private own = new Map<string, Texts>(); // what was changed from here

  constructor(private readonly tools: ApplyTools) {}

  // A change is to be looked at more often.
  get isBusy(): boolean {
    return this.followed.size > 0;
  }

  // Throws what hindered it; then it is on no host.
  async begin(change: Change, texts: Texts): Promise<void> {
    this.ended.value = undefined;
    this.own.set(change.id, texts);
    this.followed.set(change.id, [...change.edits.keys()]);
    try {
      await applyChange(this.tools, change);
    } catch (failure) {
      this.own.delete(change.id);
      this.followed.delete(change.id);
      throw failure;
    }
  }

  keep(id: string): Promise<void> {
    return confirmChange(this.tools, this.hostsOf(id), id);
  }

  // One host that takes it back is enough: it tells the others.
  async undo(id: string): Promise<void> {
    await Promise.any(this.hostsOf(id).map((host) => this.tools.ask(host, { ask: 'conf_undo', change: id }))).catch(
      ({ errors }: AggregateError) => {
        throw errors[0];
      },
    );
  }

  // `answers`: of the hosts that are there. Returns the texts of changes that were made from here and went back.
  follow(answers: HostState[]): Texts {
    const states = new Map([...this.states.value, ...answers.map((state) => [state.host, state] as const)]);
    this.states.value = states;
    this.statesAt.value = performance.now();
    for (const { id, hosts, state } of this.underWay.value) {
      if (state === 'locked' && !this.followed.has(id)) continue;
      const known = this.followed.get(id) ?? [];
      this.followed.set(id, [...new Set([...known, ...hosts.map(({ host }) => host)])]);
    }
    return [...this.followed].flatMap(([id, hosts]) => this.conclude(id, hosts, states));
  }

  private conclude(id: string, hosts: string[], states: Map<string, HostState>): Texts {
    const ended = endOf(id, hosts, states);
    if (ended === undefined) return [];
    const texts = this.own.get(id) ?? [];
    this.followed.delete(id);
    this.own.delete(id);
    this.ended.value = ended;
    return ended.kept ? [] : texts;
  }

  private hostsOf(id: string): string[] {
    const hosts = this.followed.get(id);
    if (hosts === undefined) throw new Error('this change is over');
    return hosts;
  }
}
