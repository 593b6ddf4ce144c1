// Why a message arrives, or does not.
//
// Each router on the route is asked what it would do with the message, beginning with the own one. Where the last one
// does not deliver it, the cause is looked for in this order: the link that leads there is broken; its router
// is away; the address is registered at a router that this one has no route to; nobody has registered it.

import type { Admin } from '../model/admin';
import { fieldsOf, type Widths } from '../tims/address';
import { types } from '../tims/header';
import { age } from '../ui/quantities';
import type { LinkItem, RouteAnswer, RouterItem } from './reports';

export interface Explanation {
  steps: RouteAnswer[];
  arrives: boolean;
  cause: string;
  remedy: string;
}

const stepsMax = 20;

export async function explain(
  admin: Admin,
  to: string,
  from: string | undefined,
  widths: Widths,
): Promise<Explanation> {
  const source = from === undefined ? undefined : await sourceOf(admin, from);
  if (source !== undefined && source.router === undefined)
    return {
      steps: [],
      arrives: false,
      cause: `the sender ${from} is not registered`,
      remedy: 'start the sending component, then ask again',
    };
  const question = { ask: 'route', to, type: types.getStatus, ...(from !== undefined && { from }) };
  const steps: RouteAnswer[] = [];
  let router = source?.router ?? 0;
  while (steps.length < stepsMax) {
    const answer = await admin.ask<RouteAnswer>(question, undefined, router);
    steps.push(answer);
    if (answer.verdict !== 'forward' || answer.next_router == null)
      return { steps, ...(await conclude(admin, steps, widths)) };
    router = Number(answer.next_router.raw);
  }
  return {
    steps,
    arrives: false,
    cause: 'there is a routing loop',
    remedy: 'look at the static routes of these routers',
  };
}

// The router where the sender is registered: by its route from here.
async function sourceOf(admin: Admin, from: string): Promise<{ router: number | undefined }> {
  let router = 0;
  for (let i = 0; i < stepsMax; ++i) {
    const answer = await admin.ask<RouteAnswer>({ ask: 'route', to: from, type: types.getStatus }, undefined, router);
    if (answer.verdict === 'deliver' || answer.verdict === 'self') return { router };
    if (answer.verdict !== 'forward' || answer.next_router == null) return { router: undefined };
    router = Number(answer.next_router.raw);
  }
  return { router: undefined };
}

async function conclude(admin: Admin, steps: RouteAnswer[], widths: Widths): Promise<Omit<Explanation, 'steps'>> {
  const last = steps.at(-1);
  if (last === undefined) return { arrives: false, cause: 'no router has answered', remedy: '' };
  const to = last.address;
  if (last.verdict === 'deliver' || last.verdict === 'self')
    return { arrives: true, cause: `it arrives: ${last.router} delivers it to ${ownerOf(last)}`, remedy: '' };
  const broken = await brokenLink(admin, steps, fieldsOf(Number(to.raw), widths).system);
  if (broken !== undefined) return broken;
  const missing = await missingRouter(admin, fieldsOf(Number(to.raw), widths).system);
  if (missing !== undefined) return missing;
  return {
    arrives: false,
    cause: `${last.router} knows no mailbox ${to.name}, and discards the message`,
    remedy: 'start the component; the list of a robot shows all that are registered',
  };
}

function ownerOf({ owner }: RouteAnswer): string {
  if (owner === null) return 'the router itself';
  return owner.name || owner.peer || 'a client without a name';
}

async function brokenLink(
  admin: Admin,
  steps: RouteAnswer[],
  system: number,
): Promise<Omit<Explanation, 'steps'> | undefined> {
  for (const step of steps) {
    const self = await routerNamed(admin, step.router);
    if (self === undefined) continue;
    for (const link of await admin.all<LinkItem>({ ask: 'links' }, self)) {
      const theirs = link.system === system && link.kind !== 'super';
      const above = link.kind === 'super' && step === steps.at(-1);
      if (link.state === 'up' || !(theirs || above)) continue;
      const name = link.via ?? link.name;
      return {
        arrives: false,
        cause: `the link of ${step.router} to ${name} is ${link.state} since ${age(link.since_s)}${link.refusal ? `: ${link.refusal}` : ''}`,
        remedy:
          link.state === 'down'
            ? `bring the link ${name} up at ${step.router}`
            : 'is that host up, and its network? Look at its links, too',
      };
    }
  }
  return undefined;
}

// A link that waits for its peer is forgotten after a while; the router behind it is not.
async function missingRouter(admin: Admin, system: number): Promise<Omit<Explanation, 'steps'> | undefined> {
  const routers = await admin.all<RouterItem>({ ask: 'routers' });
  const ofSystem = routers.filter((router) => router.system === system && router.kind !== 'self');
  if (ofSystem.length === 0 || ofSystem.some(({ state }) => state === 'up')) return undefined;
  const [router] = ofSystem;
  return {
    arrives: false,
    cause: `the router ${router?.name ?? router?.address.name} is not reachable since ${age(router?.since_s)}`,
    remedy: 'is that host up, and its network? Its router connects by itself when it is back',
  };
}

async function routerNamed(admin: Admin, name: string): Promise<number | undefined> {
  const routers = await admin.all<RouterItem>({ ask: 'routers' });
  const found = routers.find((router) => router.name === name);
  return found === undefined ? undefined : found.kind === 'self' ? 0 : Number(found.address.raw);
}
