// The page: which router served it, and how it is.
import { signal } from '@preact/signals';
import { render } from 'preact';
import './style.css';

interface Status {
  name: string;
  version: string;
  address: { name: string };
  uptime_s: number;
  clients: number;
  mailboxes: number;
  messages: number;
  drops: number;
  security: { insecure: boolean; exposed: string[] };
}

const PERIOD_MS = 2000;

const status = signal<Status | null>(null);
const trouble = signal('');

async function ask(): Promise<void> {
  try {
    const response = await fetch('/api/status', { signal: AbortSignal.timeout(PERIOD_MS) });
    if (!response.ok) throw new Error(await response.text());
    status.value = await response.json();
    trouble.value = '';
  } catch (error) {
    trouble.value = `The router does not answer: ${error instanceof Error ? error.message : error}`;
  }
  document.title = status.value ? `RACK: ${status.value.name}` : 'RACK';
  setTimeout(ask, PERIOD_MS);
}

function Row({ name, value }: { name: string; value: string | number }) {
  return (
    <tr>
      <th scope="row">{name}</th>
      <td>{value}</td>
    </tr>
  );
}

function Page() {
  const now = status.value;
  return (
    <main>
      {now?.security.exposed.includes('http') && (
        <p class="alarm">Anybody in this network can drive this robot: its router has no keys (security.insecure).</p>
      )}
      <h1>{now?.name ?? 'RACK'}</h1>
      <p role="status" class={trouble.value ? 'alarm' : 'good'}>
        {trouble.value || (now ? 'The router is running.' : 'Asking the router ...')}
      </p>
      {now && (
        <table class={trouble.value ? 'stale' : ''}>
          <tbody>
            <Row name="Address" value={now.address.name} />
            <Row name="Version" value={now.version} />
            <Row name="Running for" value={`${Math.floor(now.uptime_s)} s`} />
            <Row name="Clients" value={now.clients} />
            <Row name="Mailboxes" value={now.mailboxes} />
            <Row name="Messages delivered" value={now.messages} />
            <Row name="Messages dropped" value={now.drops} />
          </tbody>
        </table>
      )}
    </main>
  );
}

render(<Page />, document.body);
void ask();
