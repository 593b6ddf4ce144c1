// Who is connected to a router: programs of its host, programs over TCP, browsers.

import { useConsole } from '../app/console';
import { route, setOption } from '../app/route';
import { FilterBox } from '../ui/filter_box';
import { age, bytes } from '../ui/quantities';
import { useAdminList } from './admin_list';
import { askedRouter, RouterChoice } from './asked_router';
import type { ClientItem } from './reports';

export function Clients() {
  const router = askedRouter();
  return <ClientList key={router} router={router} />;
}

function ClientList({ router }: { router: number }) {
  const { admin } = useConsole();
  const filter = route.value.options.get('filter') ?? '';
  const { items, trouble } = useAdminList(
    () => admin.all<ClientItem>({ ask: 'clients' }, router),
    `clients ${router}`,
    3000,
  );
  const shown = (items ?? [])
    .filter((client) => matches(client, filter))
    .sort((a, b) => b.drops - a.drops || b.out_bytes + b.in_bytes - a.out_bytes - a.in_bytes);
  return (
    <>
      <div class="tools">
        <RouterChoice />
        <FilterBox
          label="Filter clients"
          placeholder="Name, kind or user"
          value={filter}
          change={(text) => setOption('filter', text)}
        />
        <span class="small faint" role="status">
          {items !== undefined && `${shown.length} of ${items.length} clients`}
        </span>
      </div>
      {trouble !== '' && <p class="bad">{trouble}</p>}
      {shown.length > 0 && <Table items={shown} />}
    </>
  );
}

const kinds = { local: 'on its host', tcp: 'TCP', websocket: 'browser' };

function Table({ items }: { items: ClientItem[] }) {
  return (
    <div class="sheet wide-sheet">
      <table class="list">
        <thead>
          <tr>
            <th scope="col">Client</th>
            <th scope="col">Connected by</th>
            <th scope="col">Since</th>
            <th scope="col">Mailboxes</th>
            <th scope="col">Has sent</th>
            <th scope="col">Has got</th>
            <th scope="col">Waiting</th>
            <th scope="col">Dropped</th>
          </tr>
        </thead>
        <tbody>
          {items.map((client) => (
            <tr key={`${client.port} ${client.id}`}>
              <th scope="row">
                {nameOf(client)} {client.pid !== null && <span class="faint">process {client.pid}</span>}
              </th>
              <td>
                {kinds[client.port] ?? client.port} <span class="faint">{client.peer}</span>
                {client.subject && `, ${client.subject}`}
              </td>
              <td>{age(client.connected_s)}</td>
              <td>{client.mailboxes}</td>
              <td>{bytes(client.in_bytes)}</td>
              <td>{bytes(client.out_bytes)}</td>
              <td>{bytes(client.queue_bytes)}</td>
              <td class={client.drops > 0 ? 'warn' : ''}>
                {client.drops > 0 ? `${client.drops} (${bytes(client.drop_bytes)})` : '0'}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

const nameOf = ({ name, peer, id }: ClientItem) => name ?? peer ?? `client ${id}`;

// All words, in any order.
function matches(client: ClientItem, filter: string): boolean {
  const { port, peer, pid, subject } = client;
  const text = `${nameOf(client)} ${kinds[port] ?? port} ${peer ?? ''} ${pid ?? ''} ${subject ?? ''}`.toLowerCase();
  return filter
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}
