// Who drives which robot. A robot's driving lease is kept by the router through which all commands for it pass: the
// system router of the robot or, if it has none, the own router. It must be renewed, so it ends with the page.

import { type ReadonlySignal, type Signal, signal } from '@preact/signals';
import type { Client } from '../tims/client';
import { type Admin, AdminError } from './admin';

export interface Lease {
  robot: number;
  holder: string;
  age_s: number;
}

interface RouterItem {
  kind: string;
  role: string | null;
  system: number | null;
  state: string;
  address: { raw: string } | null;
}

interface Held {
  router: number; // 0: the own
  ended: (why: string) => void;
}

const renewPeriod = 1000; // ms; a lease lasts 5 s
const routersTime = 15_000; // ms that the list of routers is believed where nothing is changed

export class Leases {
  private readonly heldSignal = signal<ReadonlySet<number>>(new Set());
  private held = new Map<number, Held>();
  private stopRenewing: (() => void) | undefined;
  private known: { routers: Promise<Map<number, number>>; at: number } | undefined;

  constructor(
    client: Pick<Client, 'connection'>,
    private readonly admin: Pick<Admin, 'ask' | 'all'>,
    readonly name: Signal<string>, // how others see this console
    private readonly repeat = repeatedly,
  ) {
    client.connection.subscribe(({ state }) => {
      if (state === 'connected') return;
      this.known = undefined;
      this.endAll('the connection to the router is lost');
    });
  }

  // The robots that this console drives.
  get own(): ReadonlySignal<ReadonlySet<number>> {
    return this.heldSignal;
  }

  // Throws who drives the robot, unless it is `over`: then the lease is taken from its holder. `ended` is called when
  // the lease ends otherwise than by release().
  async take(
    robot: number,
    options: { stick?: number; over?: boolean; ended?: (why: string) => void } = {},
  ): Promise<void> {
    const router = (await this.routers()).get(robot) ?? 0;
    await this.admin.ask(
      {
        ask: 'lease',
        robot,
        do: options.over ? 'take_over' : 'take',
        name: this.name.value,
        ...(options.stick !== undefined && { stick: `0x${options.stick.toString(16).padStart(8, '0')}` }),
      },
      undefined,
      router,
    );
    this.held.set(robot, { router, ended: options.ended ?? (() => {}) });
    this.changed();
  }

  async release(robot: number): Promise<void> {
    const held = this.held.get(robot);
    if (held === undefined) return;
    this.held.delete(robot);
    this.changed();
    // It ends by itself, too.
    await this.admin.ask({ ask: 'lease', robot, do: 'release' }, undefined, held.router).catch(() => {});
  }

  // For one command: nobody else drives meanwhile.
  async during<Result>(robot: number, action: () => Promise<Result>): Promise<Result> {
    if (this.held.has(robot)) return action();
    await this.take(robot);
    try {
      return await action();
    } finally {
      await this.release(robot);
    }
  }

  // Of those robots that somebody drives. A router that does not answer knows none. Pages ask this each second or so: which
  // router is whose, a long list in a large fleet, is asked less often, and again when a router does not answer.
  async holders(robots: number[]): Promise<Map<number, Lease>> {
    const routers = await this.knownRouters();
    const wanted = new Set(robots);
    const asked = new Set(robots.map((robot) => routers.get(robot) ?? 0));
    const answers = await Promise.allSettled(
      [...asked].map(async (router) =>
        (await this.admin.all<Lease>({ ask: 'leases' }, router)).filter(
          ({ robot }) => wanted.has(robot) && (routers.get(robot) ?? 0) === router,
        ),
      ),
    );
    if (answers.some(({ status }) => status === 'rejected')) this.known = undefined;
    const leases = answers.flatMap((answer) => (answer.status === 'fulfilled' ? answer.value : []));
    return new Map(leases.map((lease) => [lease.robot, lease]));
  }

  private knownRouters(): Promise<Map<number, number>> {
    const now = performance.now();
    if (this.known === undefined || now > this.known.at + routersTime) {
      const known = { routers: this.routers(), at: now };
      this.known = known;
      known.routers.catch(() => {
        if (this.known === known) this.known = undefined;
      });
    }
    return this.known.routers;
  }

  // The system routers that the own one and the one above know, by robot; 0: the own.
  private async routers(): Promise<Map<number, number>> {
    const own = await this.admin.all<RouterItem>({ ask: 'routers' });
    const found = new Map<number, number>();
    const add = (items: RouterItem[], self: number) => {
      for (const { role, system, kind, state, address } of items)
        if (role === 'system' && system !== null && address !== null && (kind === 'self' || state === 'up'))
          if (!found.has(system)) found.set(system, kind === 'self' ? self : Number(address.raw));
    };
    add(own, 0);
    const above = own.find(({ kind, state }) => kind === 'super' && state === 'up')?.address;
    if (above) {
      const router = Number(above.raw);
      add(await this.admin.all<RouterItem>({ ask: 'routers' }, router).catch(() => []), router);
    }
    return found;
  }

  private async renew(): Promise<void> {
    for (const [robot, held] of [...this.held]) {
      try {
        await this.admin.ask({ ask: 'lease', robot, do: 'renew' }, renewPeriod, held.router);
      } catch (error) {
        // Without an answer it may still be there: the next turn tries again.
        if (error instanceof AdminError && error.code === 'lease_not_held') this.end(robot, held, error.message);
      }
    }
  }

  private endAll(why: string): void {
    for (const [robot, held] of [...this.held]) this.end(robot, held, why);
  }

  private end(robot: number, held: Held, why: string): void {
    if (this.held.get(robot) !== held) return;
    this.held.delete(robot);
    this.changed();
    held.ended(why);
  }

  private changed(): void {
    this.heldSignal.value = new Set(this.held.keys());
    if (this.held.size > 0) {
      this.stopRenewing ??= this.repeat(() => void this.renew(), renewPeriod);
    } else {
      this.stopRenewing?.();
      this.stopRenewing = undefined;
    }
  }
}

// Returns what ends it.
function repeatedly(action: () => void, period: number): () => void {
  const timer = setInterval(action, period);
  return () => clearInterval(timer);
}
