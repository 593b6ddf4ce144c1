// What is registered at a router, where it is reached, and what its owner has lost since it does not read fast enough.

import { useConsole } from '../app/console';
import { route, routeText, setOption } from '../app/route';
import { FilterBox } from '../ui/filter_box';
import { age } from '../ui/quantities';
import { useAdminList } from './admin_list';
import { askedRouter, RouterChoice } from './asked_router';
import type { MailboxItem } from './reports';

const rowsMax = 500;

export function Mailboxes() {
  const router = askedRouter();
  return <MailboxList key={router} router={router} />;
}

function MailboxList({ router }: { router: number }) {
  const { admin } = useConsole();
  const filter = route.value.options.get('filter') ?? '';
  const question = { ask: 'mailboxes', match: patternOf(filter), limit: rowsMax };
  const { items, trouble } = useAdminList(
    async () => (await admin.ask<{ items: MailboxItem[] }>(question, undefined, router)).items,
    `${router} ${question.match}`,
  );
  return (
    <>
      <div class="tools">
        <RouterChoice />
        <FilterBox
          label="Filter mailboxes"
          placeholder="Ladar, 71, Ladar(71/*)"
          value={filter}
          change={(text) => setOption('filter', text)}
        />
        <span class="small faint" role="status">
          {items !== undefined && (items.length < rowsMax ? `${items.length} mailboxes` : `the first ${rowsMax}`)}
        </span>
      </div>
      {trouble !== '' && <p class="bad">{trouble}</p>}
      {items !== undefined && items.length > 0 && <Table items={items} />}
    </>
  );
}

// A class or a robot alone is enough.
export function patternOf(text: string): string {
  const wanted = text.trim();
  if (/^\d+$/.test(wanted)) return `*(${wanted}/*)`;
  if (/^\w+$/.test(wanted)) return `${wanted}(*/*)`;
  return wanted === '' ? '*' : wanted;
}

function Table({ items }: { items: MailboxItem[] }) {
  return (
    <div class="sheet wide-sheet">
      <table class="list">
        <thead>
          <tr>
            <th scope="col">Mailbox</th>
            <th scope="col">Reached over</th>
            <th scope="col">Owner</th>
            <th scope="col">Since</th>
            <th scope="col">Waiting</th>
            <th scope="col">Received</th>
            <th scope="col">Lost</th>
          </tr>
        </thead>
        <tbody>
          {items.map((item) => (
            <tr key={item.address.raw}>
              <td>{item.address.name}</td>
              <td>
                {item.router === null ? (
                  (item.via ?? 'the router itself')
                ) : (
                  <a title="As its own router sees it" href={addressOf(item.router.raw)}>
                    {item.via}
                  </a>
                )}
              </td>
              <td>{item.owner?.name ?? item.owner?.peer}</td>
              <td>{age(item.age_s)}</td>
              <td>{item.waiting !== undefined && `${item.waiting} of ${item.slots}`}</td>
              <td>{item.received}</td>
              <td class={lostOf(item) > 0 ? 'warn' : ''} title={lossesOf(item)}>
                {item.received !== undefined && (lostOf(item) > 0 ? lossesOf(item) : '0')}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function addressOf(router: string): string {
  const options = new URLSearchParams(route.value.options);
  options.set('router', router);
  return routeText({ ...route.value, options });
}

const lostOf = ({ replaced = 0, refused = 0, too_big = 0 }: MailboxItem) => replaced + refused + too_big;

function lossesOf({ replaced = 0, refused = 0, too_big = 0 }: MailboxItem): string {
  return [
    replaced > 0 && `${replaced} for newer ones`,
    refused > 0 && `${refused} refused, it was full`,
    too_big > 0 && `${too_big} too big`,
  ]
    .filter(Boolean)
    .join(', ');
}
