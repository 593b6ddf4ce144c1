// The router that a view of the network is about: as the address of the page says, without it the own one.

import { useConsole } from '../app/console';
import { route, setOption } from '../app/route';
import { useAdminList } from './admin_list';
import type { RouterItem } from './reports';

// Its address; 0: the own one.
export function askedRouter(): number {
  const address = Number(route.value.options.get('router') ?? 0);
  return Number.isInteger(address) ? address : 0;
}

// The own router, its neighbours, and that of the address of the page; the list of routers leads to all others.
export function RouterChoice() {
  const { admin } = useConsole();
  const { items = [] } = useAdminList(() => admin.all<RouterItem>({ ask: 'routers' }), 'router choice', 5000);
  const chosen = route.value.options.get('router') ?? '';
  const others = items.filter(({ kind, state }) => kind !== 'self' && state === 'up');
  const isOther = chosen !== '' && !others.some(({ address }) => address.raw === chosen);
  return (
    <label>
      Router{' '}
      <select value={chosen} onChange={(event) => setOption('router', event.currentTarget.value)}>
        <option value="">{items.find(({ kind }) => kind === 'self')?.name ?? 'this one'}</option>
        {others.map(({ address, name }) => (
          <option key={address.raw} value={address.raw}>
            {name ?? address.name}
          </option>
        ))}
        {isOther && <option value={chosen}>{chosen}</option>}
      </select>
    </label>
  );
}
