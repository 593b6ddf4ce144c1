// Planned components as they are found in the fleet.

import { useEffect } from 'preact/hooks';
import { type Console, useConsole, widthsOf } from '../app/console';
import type { Component } from '../model/fleet';
import { addressOf } from '../tims/address';
import { pageVisible } from '../ui/use_stream';
import { type PlannedComponent, resolved } from './components';
import { nodeId } from './place';
import type { RunningValues } from './running';
import type { Studio } from './studio';
import { useStudio } from './workshop';

export function addressOfPlanned(console: Console, studio: Studio, component: PlannedComponent): number | undefined {
  const program = studio.programOf(component);
  if (program === undefined) return undefined;
  const { system, instance } = component;
  return addressOf(
    { system: systemOf(studio, component, system), classId: program.class_id, instance },
    widthsOf(console),
  );
}

// A robot file without a system runs with that of its router.
function systemOf(studio: Studio, { key, host }: PlannedComponent, system: number): number {
  if (studio.parsed.value.get(key)?.values.system !== undefined) return system;
  return studio.host(host)?.list?.router.system ?? system;
}

export function liveOf(console: Console, studio: Studio, component: PlannedComponent): Component | undefined {
  const address = addressOfPlanned(console, studio, component);
  void console.fleet.robots.value;
  return address === undefined ? undefined : console.fleet.component(address);
}

// The running values of these components, renewed at a period while they are looked at.
export function useRunningValues(
  components: PlannedComponent[],
  period = 5000,
): (one: PlannedComponent) => RunningValues {
  const console = useConsole();
  const { studio, running } = useStudio();
  const live = components.flatMap((component) => liveOf(console, studio, component) ?? []);
  const visible = pageVisible.value;
  useEffect(() => {
    if (!visible) return;
    const load = () => void running.loadValues(live);
    load();
    const timer = setInterval(load, period);
    return () => clearInterval(timer);
  }, [live.map(({ address }) => address).join(), visible, period]);
  return (component) => running.values.value.get(addressOfPlanned(console, studio, component) ?? -1) ?? none;
}

const none: RunningValues = new Map();

export const fileValue = (text: string | undefined, component: PlannedComponent) =>
  text === undefined ? undefined : resolved(text, component.system);

export { nodeId };
