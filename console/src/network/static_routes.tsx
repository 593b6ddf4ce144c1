// The routes of a router that somebody has set, beside those that it finds by itself.

import { useConsole } from '../app/console';
import { useAdminList } from './admin_list';
import type { StaticRoute } from './reports';

interface Routes {
  static: StaticRoute[];
}

export function StaticRoutes({ router }: { router: number }) {
  const { admin } = useConsole();
  const { items, trouble } = useAdminList(
    async () => (await admin.ask<Routes>({ ask: 'routes', limit: 1 }, undefined, router)).static,
    `static routes ${router}`,
    5000,
  );
  if (trouble !== '') return <p class="bad">Its static routes are not known: {trouble}</p>;
  if (items === undefined || items.length === 0) return null;
  return (
    <section>
      <h2 class="tools">Static routes</h2>
      <div class="sheet">
        <table class="list">
          <thead>
            <tr>
              <th scope="col">To</th>
              <th scope="col">Over</th>
            </tr>
          </thead>
          <tbody>
            {items.map(({ match, via }) => (
              <tr key={`${match} ${via}`}>
                <th scope="row">{match}</th>
                <td>{via}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}
