// Whether a link serves as it should, and if not, why, in words. Pure.

import { bytes, duration, percent } from '../ui/quantities';
import type { InjectedFaults, LinkItem } from './reports';

export type Health = 'good' | 'warn' | 'bad';

export interface LinkTrouble {
  health: Exclude<Health, 'good'>;
  text: string;
}

// Shares of lost datagrams. Below the first, repeating them costs less than anybody notices.
const lossSeen = 0.02;
const lossGrave = 0.1;
const delaySeen = 0.3; // s; this long a message waits before it goes out
const clockSeen = 1; // s; data of other hosts seem older or newer by that

export function linkTroubles(link: LinkItem): LinkTrouble[] {
  return link.state === 'up' ? troublesOfSession(link) : [whyNotUp(link)];
}

// What somebody has injected to try what happens: no trouble by itself. Empty: nothing.
export function injectedFaults({ faults }: LinkItem): string {
  return faults == null ? '' : `Faults are injected into what is sent to it: ${faultsText(faults)}`;
}

// With the injected faults, which are the likely cause.
export function explainedTroubles(link: LinkItem): LinkTrouble[] {
  const [troubles, faults] = [linkTroubles(link), injectedFaults(link)];
  return troubles.length === 0 || faults === '' ? troubles : [...troubles, { health: 'warn', text: faults }];
}

function whyNotUp({ refusal, state }: LinkItem): LinkTrouble {
  return { health: 'bad', text: refusal === null ? `The link is ${state}` : `Refused: ${refusal}` };
}

function troublesOfSession(link: LinkItem): LinkTrouble[] {
  const troubles: LinkTrouble[] = [];
  const { loss_out, loss_in, queue_delay_s, clock } = link;
  for (const [loss, where] of [
    [loss_out, 'to it'],
    [loss_in, 'from it'],
  ] as const)
    if (loss !== null && loss >= lossSeen)
      troubles.push({
        health: loss >= lossGrave ? 'bad' : 'warn',
        text: `${percent(loss)} of what is sent ${where} is lost`,
      });
  if (queue_delay_s !== null && queue_delay_s >= delaySeen)
    troubles.push({
      health: 'warn',
      text: `What is sent to it waits for ${duration(queue_delay_s)}: the line is too slow`,
    });
  if (clock != null && Math.abs(clock.offset_s) >= clockSeen)
    troubles.push({
      health: 'warn',
      text: `Its clock is ${duration(Math.abs(clock.offset_s))} ${clock.offset_s > 0 ? 'ahead' : 'behind'}`,
    });
  return troubles;
}

function faultsText(faults: InjectedFaults): string {
  if (faults.blackout) return 'nothing is sent';
  const parts: [number, string][] = [
    [faults.loss, `${percent(faults.loss)} lost`],
    [faults.duplicate, `${percent(faults.duplicate)} sent twice`],
    [faults.reorder, `${percent(faults.reorder)} out of order`],
    [faults.delay_s, `${duration(faults.delay_s)} late`],
    [faults.jitter_s, `up to ${duration(faults.jitter_s)} later`],
    [faults.rate, `at most ${bytes(faults.rate)}/s`],
  ];
  return parts
    .filter(([size]) => size > 0)
    .map(([, text]) => text)
    .join(', ');
}

export function worst(troubles: LinkTrouble[]): Health {
  if (troubles.length === 0) return 'good';
  return troubles.some(({ health }) => health === 'bad') ? 'bad' : 'warn';
}
