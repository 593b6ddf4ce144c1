// What can be done to a simulated world and to its network: people, obstacles, cables, and the faults of links.

import { useConsole } from '../app/console';
import { firstOf } from '../map/follow';
import { LinkFaults } from './link_faults';
import { World } from './world';

export function SimulationPage() {
  const console = useConsole();
  const worlds = console.fleet.robots.value.flatMap((robot) => firstOf(robot, 'World') ?? []);
  return (
    <section>
      <div class="tools">
        <h1>Simulation</h1>
      </div>
      {worlds.length === 0 && (
        <p class="empty faint">
          No simulated world has registered. <code>timsctl up deploy/robots/emulated.toml</code> starts one.
        </p>
      )}
      {worlds.map((world) => (
        <World key={world.address} world={world} />
      ))}
      <LinkFaults />
    </section>
  );
}
