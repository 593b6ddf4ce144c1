// The links of a router: the worst first, with what is lost on them and why; and what the router has dropped.

import { useRef } from 'preact/hooks';
import { useConsole } from '../app/console';
import { useAttempt } from '../ui/attempt';
import { Icon } from '../ui/icons';
import { needs } from '../ui/needs';
import { age, bytes, duration, percent } from '../ui/quantities';
import { useAdminList } from './admin_list';
import { askedRouter, RouterChoice } from './asked_router';
import { Drops } from './drops';
import { injectedFaults, linkTroubles, worst } from './link_health';
import { Ping } from './ping';
import type { LinkItem } from './reports';
import { StaticRoutes } from './static_routes';

const period = 2000;

export function Links() {
  const router = askedRouter();
  return (
    <>
      <div class="tools">
        <RouterChoice />
        <Ping key={`ping ${router}`} router={router} />
      </div>
      <LinkList key={router} router={router} />
      <StaticRoutes key={`routes ${router}`} router={router} />
      <Drops key={`drops ${router}`} router={router} />
    </>
  );
}

function LinkList({ router }: { router: number }) {
  const { admin } = useConsole();
  const { items, trouble } = useAdminList(
    () => admin.all<LinkItem>({ ask: 'links' }, router),
    `links ${router}`,
    period,
  );
  const before = useRef(new Map<string, { bytesIn: number; bytesOut: number; at: number }>());
  if (items === undefined) return <p class="faint summary">{trouble || 'Asking the router …'}</p>;
  if (items.length === 0) return <p class="empty faint">This router has no links to other routers.</p>;
  const rates = ratesOf(items, before.current);
  const sorted = [...items].sort((a, b) => rank(a) - rank(b) || b.drops - a.drops);
  return (
    <ul class="links">
      {sorted.map((link) => (
        <Link key={link.name ?? link.via} link={link} rate={rates.get(link.name ?? '')} router={router} />
      ))}
    </ul>
  );
}

const ranks = { bad: 0, warn: 1, good: 2 };
const rank = (link: LinkItem) => ranks[worst(linkTroubles(link))];

interface Rate {
  in: number;
  out: number;
}

function ratesOf(items: LinkItem[], before: Map<string, { bytesIn: number; bytesOut: number; at: number }>) {
  const rates = new Map<string, Rate>();
  const now = performance.now();
  for (const { name, wire_bytes_in, wire_bytes_out } of items) {
    const key = name ?? '';
    const last = before.get(key);
    if (last !== undefined && now > last.at + period / 2) {
      const seconds = (now - last.at) / 1000;
      rates.set(key, { in: (wire_bytes_in - last.bytesIn) / seconds, out: (wire_bytes_out - last.bytesOut) / seconds });
    }
    before.set(key, { bytesIn: wire_bytes_in, bytesOut: wire_bytes_out, at: now });
  }
  return rates;
}

interface LinkProperties {
  link: LinkItem;
  rate: Rate | undefined;
  router: number; // whose link it is
}

function Link({ link, rate, router }: LinkProperties) {
  const { admin } = useConsole();
  const { attempt, Failure } = useAttempt();
  const change = (what: 'up' | 'down' | 'reset') =>
    void attempt(() => admin.ask({ ask: 'link', link: link.via ?? link.name, do: what }, undefined, router));
  const up = link.state === 'up';
  const troubles = linkTroubles(link);
  const health = worst(troubles);
  const values: [string, string][] = [
    ['since', age(link.since_s)],
    ['round trip', duration(link.rtt_s)],
    ['loss in', percent(link.loss_in)],
    ['loss out', percent(link.loss_out)],
    ['in', rate === undefined ? '' : `${bytes(Math.max(0, rate.in))}/s`],
    ['out', rate === undefined ? '' : `${bytes(Math.max(0, rate.out))}/s`],
    ['waiting', bytes(link.queue_bytes?.reduce((sum, each) => sum + each, 0))],
    ['dropped', `${link.drops}`],
    ['mailboxes', `${link.mailboxes}`],
    ['largest datagram', bytes(link.mtu_bytes)],
  ];
  return (
    <li class={`link ${cardOf[health]}`}>
      <h2>
        {link.name ?? link.via}{' '}
        <span class={`word ${health}`}>{up && health !== 'good' ? 'up, poor' : link.state}</span>
      </h2>
      <p class="faint">
        {link.kind} router {link.address?.name}
        {link.path && `, over ${link.path.toUpperCase()}`}
        {link.path_why && ` (${link.path_why})`}
        {link.peer_address && `, ${link.peer_address}`}
      </p>
      {troubles.map(({ health: grade, text }) => (
        <p key={text} class={`link-trouble ${grade}`}>
          <Icon name="warning" /> {text}
        </p>
      ))}
      {link.faults != null && <p class="warn">{injectedFaults(link)}</p>}
      {link.paths
        ?.filter(({ trouble }) => trouble !== null)
        .map(({ path, trouble }) => (
          <p key={path} class="warn">
            {path.toUpperCase()}: {trouble}
          </p>
        ))}
      <dl class="values">
        {values
          .filter(([, value]) => value !== '')
          .map(([name, value]) => (
            <div key={name}>
              <dt>{name}</dt>
              <dd>{value}</dd>
            </div>
          ))}
      </dl>
      <Classes link={link} />
      <p class="actions">
        <button type="button" {...needs('link')} onClick={() => change(up ? 'down' : 'up')}>
          {up ? 'Take down' : 'Bring up'}
        </button>
        <button type="button" {...needs('link')} onClick={() => change('reset')}>
          Reset
        </button>
      </p>
      <Failure />
    </li>
  );
}

const cardOf = { good: '', warn: 'doubtful', bad: 'troubled' };

// What waits and what went out, by class of priority; the routers' own messages come last.
function Classes({ link: { queue_bytes: waiting, class_bytes_out: sent } }: { link: LinkItem }) {
  return (
    <details class="classes">
      <summary>By priority</summary>
      <table class="list one-line">
        <thead>
          <tr>
            <th scope="col">Class</th>
            <th scope="col">Waiting</th>
            <th scope="col">Sent</th>
          </tr>
        </thead>
        <tbody>
          {waiting.map((bytesWaiting, i) => (
            <tr key={i}>
              <th scope="row">{i + 1 === waiting.length ? 'routers' : i}</th>
              <td>{bytes(bytesWaiting)}</td>
              <td>{bytes(sent[i])}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </details>
  );
}
