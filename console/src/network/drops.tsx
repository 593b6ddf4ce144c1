// The messages that a router has dropped since its start, and why.

import { useConsole } from '../app/console';
import { useAdminList } from './admin_list';
import type { OutcomeItem } from './reports';

export function Drops({ router }: { router: number }) {
  const { admin } = useConsole();
  const { items = [], trouble } = useAdminList(
    () => admin.all<OutcomeItem>({ ask: 'stats' }, router),
    `drops ${router}`,
    5000,
  );
  const dropped = items.filter((item) => item.dropped).sort((a, b) => b.messages - a.messages);
  if (trouble !== '') return <p class="bad">What it has dropped is not known: {trouble}</p>;
  if (dropped.length === 0) return null;
  return (
    <section>
      <h2 class="tools">Dropped here since its start</h2>
      <div class="sheet">
        <table class="list">
          <thead>
            <tr>
              <th scope="col">Messages</th>
              <th scope="col">Why</th>
              <th scope="col">Came from</th>
              <th scope="col">Class of priority</th>
            </tr>
          </thead>
          <tbody>
            {dropped.map(({ port, class: priority, outcome, meaning, messages }) => (
              <tr key={`${port} ${priority} ${outcome}`}>
                <td>{messages}</td>
                <td>{meaning}</td>
                <td>{port}</td>
                <td>{priority}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}
