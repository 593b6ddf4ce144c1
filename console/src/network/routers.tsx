// All routers of the fleet, and whether they answer.

import { useSignal } from '@preact/signals';
import { useConsole } from '../app/console';
import { route, setOption } from '../app/route';
import { FilterBox } from '../ui/filter_box';
import { Lamp } from '../ui/lamp';
import { age, duration } from '../ui/quantities';
import { useAdminList } from './admin_list';
import type { RouterItem } from './reports';
import { type TreeRow, treeOfRouters } from './router_tree';

const words = { asked: 'asked …', up: 'up', down: 'not reachable' };
const rowsAtOnce = 200; // and all that are not reachable
const lamps = { asked: 'unknown', up: 'on', down: 'error' } as const;

export function Routers() {
  const { admin } = useConsole();
  const filter = route.value.options.get('filter') ?? '';
  const shown = useSignal(rowsAtOnce);
  const { items, trouble } = useAdminList<TreeRow>(
    (publish) => treeOfRouters((address) => admin.all<RouterItem>({ ask: 'routers' }, address), publish),
    'routers',
    3000,
  );
  if (items === undefined) return <p class="summary faint">{trouble || 'Asking the routers …'}</p>;
  const down = items.filter(({ state }) => state === 'down').length;
  const found = items.filter(({ router }) => matches(router, filter));
  const visible = found.filter(({ state }, i) => i < shown.value || state === 'down');
  return (
    <>
      <div class="tools">
        <p class="summary" aria-live="polite">
          {items.length === 1 ? '1 router' : `${items.length} routers`}
          {down > 0 && <strong class="bad">, {down} not reachable</strong>}
        </p>
        <span class="grow" />
        <FilterBox label="Filter routers" value={filter} change={(text) => setOption('filter', text)} />
      </div>
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
            {visible.map(({ router, depth, clock, state }) => (
              <tr key={`${router.address.raw} ${depth}`} class={state === 'down' ? 'bad-row' : ''}>
                <td style={{ paddingInlineStart: `${0.75 + 1.5 * depth}rem` }}>
                  <Lamp state={lamps[state]} />{' '}
                  {state === 'up' ? (
                    <a href={`#/network?tab=links&router=${router.address.raw}`}>
                      {router.name ?? router.address.name}
                    </a>
                  ) : (
                    (router.name ?? 'unknown')
                  )}
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
      {found.length > visible.length && (
        <button type="button" onClick={() => (shown.value += rowsAtOnce)}>
          Show {Math.min(rowsAtOnce, found.length - visible.length)} more of {found.length}
        </button>
      )}
    </>
  );
}

const matches = ({ name, address }: RouterItem, filter: string) =>
  `${name ?? ''} ${address.name}`.toLowerCase().includes(filter.trim().toLowerCase());
