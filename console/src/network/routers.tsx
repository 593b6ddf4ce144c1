// All routers of the fleet as a tree, each below the router that it is connected to.

import { useConsole } from '../app/console';
import type { Admin } from '../model/admin';
import { age, duration } from '../ui/quantities';
import { useAdminList } from './admin_list';
import type { RouterItem } from './reports';

interface TreeItem {
  router: RouterItem;
  depth: number;
  clock: number | undefined; // of the root minus this one's, s
}

const routersMax = 2000;

export function Routers() {
  const { admin } = useConsole();
  const { items, trouble } = useAdminList(() => walk(admin), 'routers', 3000);
  if (items === undefined) return <p class="faint">{trouble || 'Asking the routers …'}</p>;
  const down = items.filter(({ router }) => router.state !== 'up').length;
  return (
    <>
      <p class="summary" aria-live="polite">
        {items.length === 1 ? '1 router' : `${items.length} routers`}
        {down > 0 && <strong class="bad">, {down} not reachable</strong>}
      </p>
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
          {items.map(({ router, depth, clock }) => (
            <tr key={`${router.address.raw} ${depth}`} class={router.state === 'up' ? '' : 'bad-row'}>
              <td style={{ paddingInlineStart: `${0.75 + 1.5 * depth}rem` }}>{router.name ?? 'unknown'}</td>
              <td>{router.state === 'up' ? 'up' : 'not reachable'}</td>
              <td>{router.role}</td>
              <td>{router.address.name}</td>
              <td>{age(router.since_s)}</td>
              <td>{duration(router.rtt_s)}</td>
              <td>{clock !== undefined && duration(clock)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </>
  );
}

// Each router knows its neighbours only: they are asked in turn, from the own one.
async function walk(admin: Admin): Promise<TreeItem[]> {
  const items: TreeItem[] = [];
  const seen = new Set<string>();
  const visit = async (address: number, depth: number, clock: number | undefined, known?: RouterItem) => {
    if (items.length >= routersMax) return;
    let list: RouterItem[] = [];
    try {
      list = await admin.all<RouterItem>({ ask: 'routers' }, address);
    } catch {
      if (known !== undefined) items.push({ router: { ...known, state: 'down' }, depth, clock });
      return;
    }
    const self = list.find(({ kind }) => kind === 'self');
    if (self === undefined) return;
    seen.add(self.address.raw);
    items.push({
      router: { ...self, rtt_s: known?.rtt_s ?? null, since_s: known?.since_s ?? self.since_s },
      depth,
      clock,
    });
    for (const router of list) {
      if (router.kind === 'self' || seen.has(router.address.raw)) continue;
      seen.add(router.address.raw);
      const theirs = router.clock == null || clock === undefined ? undefined : clock + router.clock.offset_s;
      if (router.state === 'up') await visit(Number(router.address.raw), depth + 1, theirs, router);
      else items.push({ router, depth: depth + 1, clock: undefined });
    }
  };
  await visit(0, 0, 0);
  return items;
}
