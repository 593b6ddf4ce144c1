// All routers of the fleet, and whether they answer.

import { useConsole } from '../app/console';
import { Lamp } from '../ui/lamp';
import { age, duration } from '../ui/quantities';
import { useAdminList } from './admin_list';
import type { RouterItem } from './reports';
import { type TreeRow, treeOfRouters } from './router_tree';

const words = { asked: 'asked …', up: 'up', down: 'not reachable' };
const lamps = { asked: 'unknown', up: 'on', down: 'error' } as const;

export function Routers() {
  const { admin } = useConsole();
  const { items, trouble } = useAdminList<TreeRow>(
    (publish) => treeOfRouters((address) => admin.all<RouterItem>({ ask: 'routers' }, address), publish),
    'routers',
    3000,
  );
  if (items === undefined) return <p class="summary faint">{trouble || 'Asking the routers …'}</p>;
  const down = items.filter(({ state }) => state === 'down').length;
  return (
    <>
      <p class="summary" aria-live="polite">
        {items.length === 1 ? '1 router' : `${items.length} routers`}
        {down > 0 && <strong class="bad">, {down} not reachable</strong>}
      </p>
      <div class="sheet">
        <table class="list">
          <thead>
            <tr>
              <th scope="col">Router</th>
              <th scope="col">State</th>
              <th scope="col">Role</th>
              <th scope="col">Address</th>
              <th scope="col">Since</th>
              <th scope="col">Round trip</th>
              <th scope="col">Clock</th>
            </tr>
          </thead>
          <tbody>
            {items.map(({ router, depth, clock, state }) => (
              <tr key={`${router.address.raw} ${depth}`} class={state === 'down' ? 'bad-row' : ''}>
                <td style={{ paddingInlineStart: `${0.75 + 1.5 * depth}rem` }}>
                  <Lamp state={lamps[state]} /> {router.name ?? 'unknown'}
                </td>
                <td>{words[state]}</td>
                <td>{router.role}</td>
                <td>{router.address.name}</td>
                <td>{age(router.since_s)}</td>
                <td>{duration(router.rtt_s)}</td>
                <td>{clock !== undefined && duration(clock)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </>
  );
}
