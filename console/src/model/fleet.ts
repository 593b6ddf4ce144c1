// The components that the router knows, by robot, and whether each is on.
//
// The list is asked for anew when the router reports that an address has come or gone. The state of a component is
// asked for every two seconds, those that somebody looks at first, a bounded number of questions a second: a fleet
// of a thousand robots is asked in turns.

import { batch, type ReadonlySignal, type Signal, signal } from '@preact/signals';
import { className } from '../codec/catalogue';
import { classes, fieldsOf, type Widths } from '../tims/address';
import type { Client } from '../tims/client';
import { types } from '../tims/header';
import type { Admin } from './admin';
import { command } from './commands';

export type ComponentState = 'unknown' | 'on' | 'off' | 'error' | 'silent';

export interface Component {
  address: number;
  system: number;
  classId: number;
  instance: number;
  via: string;
  state: Signal<ComponentState>;
  why: Signal<string>; // it is in error, as it says itself; empty: it does not
  askedAt: number;
}

export interface Robot {
  system: number;
  components: Component[];
}

interface Mailbox {
  address: { raw: string };
  via: string;
}

// What the router names its own clients by; others are behind a link.
const ports = ['local', 'tcp', 'websocket'];

const statePeriod = 2000; // ms
const turnTime = 250;
const questionsPerTurn = 60;
const answerTime = 1500;
const eventWait = 10000;
const refreshPause = 150;
const retryTime = 1000;

export class Fleet {
  private readonly robotsSignal = signal<Robot[]>([]);
  private readonly logsSignal = signal<number[]>([]);
  private readonly listedSignal = signal(false);
  private localLogs = new Set<number>();
  private components = new Map<number, Component>();
  private watched = new Map<number, number>(); // component: number of views that show it
  private polled = new Map<Component, Status>(); // not shown yet
  private generation = 0;

  constructor(
    private readonly client: Client,
    readonly admin: Admin,
  ) {
    client.connection.subscribe(({ state, router }) => {
      ++this.generation;
      if (state === 'connected' && router !== undefined) void this.follow(this.generation, router.widths);
    });
    setInterval(() => this.askStates(), turnTime);
  }

  // Sorted by number; system 0 is the base's.
  get robots(): ReadonlySignal<Robot[]> {
    return this.robotsSignal;
  }

  // The router has listed them at least once.
  get listed(): ReadonlySignal<boolean> {
    return this.listedSignal;
  }

  // The addresses of gdos-log, one for each host that has one.
  get logs(): ReadonlySignal<number[]> {
    return this.logsSignal;
  }

  // The log runs at the own router, not behind a link.
  isLocal(log: number): boolean {
    return this.localLogs.has(log);
  }

  robot(system: number): Robot | undefined {
    return this.robots.value.find((robot) => robot.system === system);
  }

  component(address: number): Component | undefined {
    return this.components.get(address);
  }

  // These are asked first. Returns what ends it.
  watch(addresses: number[]): () => void {
    for (const address of addresses) this.watched.set(address, (this.watched.get(address) ?? 0) + 1);
    return () => {
      for (const address of addresses) {
        const views = (this.watched.get(address) ?? 1) - 1;
        if (views === 0) this.watched.delete(address);
        else this.watched.set(address, views);
      }
    };
  }

  async turn(component: Component, on: boolean): Promise<void> {
    try {
      await command(this.client, component, on ? 'ON' : 'OFF', undefined, turnOnTime);
    } finally {
      await this.askState(component);
    }
    // OFF is answered before it is off; ON would find it still on then.
    for (const deadline = performance.now() + turnOffTime; !on && ['on', 'error'].includes(component.state.value); ) {
      if (performance.now() > deadline) throw new Error('it is not off yet');
      await pause(turnPause);
      await this.askState(component);
    }
  }

  // It begins anew, with its present parameters.
  async restart(component: Component): Promise<void> {
    if (component.state.value !== 'off') await this.turn(component, false);
    await this.turn(component, true);
  }

  // Those that depend on others come last in the list, and go off first. Goes on when one does not go off; throws then.
  async turnAllOff(robot: Robot, progress: (text: string) => void = () => {}): Promise<void> {
    const components = [...robot.components].reverse().filter(({ state }) => state.value !== 'off');
    const failures: string[] = [];
    for (const [i, component] of components.entries()) {
      progress(`${i + 1} of ${components.length}: ${shortName(component)}`);
      await this.turn(component, false).catch(async (error: Error) => {
        // A joystick, for example, which this console had brought.
        if (!(await this.hasGone(component))) failures.push(`${shortName(component)}: ${error.message}`);
      });
    }
    if (failures.length > 0) throw new Error(`Not all: ${failures.join('; ')}`);
  }

  // Whether it has unregistered at the own router, whose list may show that a moment later. Nobody knows that of a component
  // behind a link: it may be the link that has gone.
  private async hasGone({ address, via }: Component): Promise<boolean> {
    if (!ports.includes(via)) return false;
    for (const deadline = performance.now() + goneTime; this.components.has(address); await pause(turnPause))
      if (performance.now() > deadline) return false;
    return this.client.connection.value.state === 'connected';
  }

  private async follow(generation: number, widths: Widths): Promise<void> {
    const current = () => generation === this.generation;
    let since: number | undefined;
    let epoch: string | undefined;
    while (current()) {
      try {
        if (since === undefined) ({ last: since, epoch } = await this.admin.ask<EventList>({ ask: 'events' }));
        const mailboxes = await this.admin.all<Mailbox>({ ask: 'routes', match: '*(*/*):0' });
        if (current()) this.update(mailboxes, widths);
        const question = { ask: 'events', since, epoch, wait_ms: eventWait };
        ({ last: since, epoch } = await this.admin.ask<EventList>(question, eventWait + answerTime));
        await pause(refreshPause);
      } catch {
        since = undefined;
        await pause(retryTime);
      }
    }
  }

  private update(mailboxes: Mailbox[], widths: Widths): void {
    const components = new Map<number, Component>();
    const logs: number[] = [];
    this.localLogs.clear();
    for (const { address, via } of mailboxes) {
      const raw = Number(address.raw);
      const { system, classId, instance } = fieldsOf(raw, widths);
      const isSink = system === 0 && instance === 0;
      if (classId === classes.textSink && !isSink) {
        logs.push(raw);
        if (ports.includes(via)) this.localLogs.add(raw);
      }
      if (classId < classes.firstComponent) continue;
      const known = this.components.get(raw);
      components.set(
        raw,
        known !== undefined
          ? Object.assign(known, { via })
          : {
              address: raw,
              system,
              classId,
              instance,
              via,
              state: signal<ComponentState>('unknown'),
              why: signal(''),
              askedAt: Number.NEGATIVE_INFINITY,
            },
      );
    }
    this.components = components;
    if (logs.join() !== this.logsSignal.value.join()) this.logsSignal.value = logs;
    this.robotsSignal.value = byRobot(components.values());
    this.listedSignal.value = true;
  }

  // What was answered since the last turn is shown at once: a page of a thousand robots is drawn four times a second,
  // and not for each answer.
  private askStates(): void {
    batch(() => {
      for (const [component, status] of this.polled) show(component, status);
    });
    this.polled.clear();
    if (this.client.connection.value.state !== 'connected' || document.hidden) return;
    const now = performance.now();
    const due = [...this.components.values()].filter((component) => now >= component.askedAt + statePeriod);
    const urgency = ({ address, askedAt }: Component) => askedAt - (this.watched.has(address) ? 1e9 : 0);
    due.sort((a, b) => urgency(a) - urgency(b));
    for (const component of due.slice(0, questionsPerTurn)) void this.poll(component);
  }

  private async poll(component: Component): Promise<void> {
    this.polled.set(component, await this.presentStatus(component));
  }

  private async askState(component: Component): Promise<void> {
    show(component, await this.presentStatus(component));
    this.polled.delete(component);
  }

  private async presentStatus(component: Component): Promise<Status> {
    component.askedAt = performance.now();
    try {
      const { type, body } = await this.client.call(component.address, types.getStatus, undefined, answerTime);
      return { state: stateOf(type), why: type === types.error ? new TextDecoder().decode(body) : '' };
    } catch {
      return { state: this.client.connection.value.state === 'connected' ? 'silent' : 'unknown', why: '' };
    }
  }
}

// Within its robot: "Scan2d/0".
export const shortName = ({ classId, instance }: Component) => `${className(classId) ?? classId}/${instance}`;

interface Status {
  state: ComponentState;
  why: string;
}

function show(component: Component, { state, why }: Status): void {
  component.state.value = state;
  component.why.value = why;
}

interface EventList {
  last: number;
  epoch: string;
}

const turnOnTime = 20000; // a device may take its time
const turnOffTime = 5000;
const turnPause = 50;
const goneTime = 1000;

const pause = (time: number) => new Promise((resolve) => setTimeout(resolve, time));

function stateOf(answer: number): ComponentState {
  switch (answer) {
    case types.enabled:
      return 'on';
    case types.disabled:
      return 'off';
    case types.error:
      return 'error';
    default:
      return 'silent';
  }
}

function byRobot(components: Iterable<Component>): Robot[] {
  const robots = new Map<number, Robot>();
  for (const component of components) {
    let robot = robots.get(component.system);
    if (robot === undefined) {
      robot = { system: component.system, components: [] };
      robots.set(component.system, robot);
    }
    robot.components.push(component);
  }
  for (const { components } of robots.values())
    components.sort((a, b) => a.classId - b.classId || a.instance - b.instance);
  return [...robots.values()].sort((a, b) => a.system - b.system);
}
