// Faults of the links of a router: loss, delay and rate of what it sends, for a router with sim.faults.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { useConsole } from '../app/console';
import type { AdminError } from '../model/admin';
import { useAdminList } from '../network/admin_list';
import { askedRouter, RouterChoice } from '../network/asked_router';
import type { LinkItem } from '../network/reports';
import { needs } from '../ui/needs';
import { duration, percent } from '../ui/quantities';

interface Faults {
  loss: number; // percent
  delay: number; // ms
  jitter: number; // ms
  blackout: boolean;
}

const none: Faults = { loss: 0, delay: 0, jitter: 0, blackout: false };

export function LinkFaults() {
  const router = askedRouter();
  return (
    <section class="box" aria-label="Faults of links">
      <h2>Faults of links</h2>
      <p class="actions">
        <RouterChoice />
      </p>
      <p class="faint">
        They change what this router sends, and are shown whoever has set them. The router needs sim.faults = true.
      </p>
      <FaultsOf key={router} router={router} />
    </section>
  );
}

function FaultsOf({ router }: { router: number }) {
  const { admin } = useConsole();
  const { items, trouble } = useAdminList(() => admin.all<LinkItem>({ ask: 'links' }, router), `links ${router}`, 3000);
  if (items === undefined) return <p class={trouble === '' ? 'faint' : 'bad'}>{trouble || 'Asking the router …'}</p>;
  if (items.length === 0) return <p class="faint">This router has no links to other routers.</p>;
  return (
    <>
      {items.map((link) => (
        <LinkFault key={link.name} name={link.via ?? link.name ?? ''} link={link} router={router} />
      ))}
    </>
  );
}

function inForce({ faults }: LinkItem): Faults {
  if (faults == null) return none;
  const { loss, delay_s, jitter_s, blackout } = faults;
  return { loss: 100 * loss, delay: 1000 * delay_s, jitter: 1000 * jitter_s, blackout };
}

function LinkFault({ name, link, router }: { name: string; link: LinkItem; router: number }) {
  const { admin } = useConsole();
  const faults = useSignal(inForce(link));
  const reported = JSON.stringify(link.faults);
  // Only what the router reports anew replaces what was entered.
  useEffect(() => {
    faults.value = inForce(link);
  }, [reported]);
  const report = useSignal({ text: '', bad: false });
  const apply = async (next: Faults) => {
    faults.value = next;
    const { loss, delay, jitter, blackout } = next;
    try {
      const question = {
        ...(next === none ? {} : link.faults),
        ask: 'fault',
        link: name,
        loss: loss / 100,
        delay_s: delay / 1000,
        jitter_s: jitter / 1000,
        blackout,
      };
      await admin.ask(question, undefined, router);
      report.value = { text: 'in force', bad: false };
    } catch (error) {
      const { message, hint } = error as AdminError;
      report.value = { text: `${message}${hint ? `; ${hint}` : ''}`, bad: true };
    }
  };
  const number = (key: 'loss' | 'delay' | 'jitter', title: string, unit: string, most: number) => (
    <label>
      {title}{' '}
      <input
        inputMode="decimal"
        size={4}
        {...needs('fault')}
        aria-label={`${title} of ${name} in ${unit}`}
        key={faults.value[key]}
        defaultValue={`${faults.value[key]}`}
        onChange={({ currentTarget: { value } }) => {
          const entered = Number(value);
          if (entered >= 0 && entered <= most) void apply({ ...faults.value, [key]: entered });
          else report.value = { text: `${title} is 0 to ${most} ${unit}`, bad: true };
        }}
      />{' '}
      {unit}
    </label>
  );
  return (
    <fieldset>
      <legend>{name}</legend>
      {number('loss', 'Loss', '%', 100)}
      {number('delay', 'Delay', 'ms', 10000)}
      {number('jitter', 'Jitter', 'ms', 10000)}
      <label>
        <input
          type="checkbox"
          checked={faults.value.blackout}
          {...needs('fault')}
          onChange={(event) => void apply({ ...faults.value, blackout: event.currentTarget.checked })}
        />{' '}
        Cut
      </label>
      <button type="button" {...needs('fault')} onClick={() => void apply(none)}>
        None
      </button>
      <span class={report.value.bad ? 'bad' : 'faint'} role="status">
        {report.value.text}
      </span>
      <span class="faint small">
        measured: {percent(link.loss_out)} lost, round trip {duration(link.rtt_s)}
      </span>
    </fieldset>
  );
}
