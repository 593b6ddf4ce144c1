// What the links have to carry: the worst case by the files, beside what is measured, by class of priority.

import { useEffect } from 'preact/hooks';
import { bytes, percent } from '../ui/quantities';
import type { Level, LinkBudget } from './protocol';
import { useStudio } from './workshop';

const period = 5000; // ms between two measurements while it is looked at

export function BudgetView() {
  const { studio } = useStudio();
  useEffect(() => {
    const measure = () => !document.hidden && void studio.measure();
    measure();
    const timer = setInterval(measure, period);
    return () => clearInterval(timer);
  }, [studio]);
  const links = studio.fleet.value?.links;
  if (links === undefined) return <p class="empty faint">Adding up what the links have to carry …</p>;
  if (links.length === 0)
    return (
      <section class="empty">
        <h2>No host has a link to another one</h2>
        <p>Each router serves its own components only.</p>
      </section>
    );
  return (
    <div class="budgets">
      <p class="faint">
        Worst case: every stream as large and as frequent as the files allow. Measured: what the routers send now. From
        70 % of what a class may use, a link is yellow, from 100 % red.
      </p>
      {/* biome-ignore lint/a11y/noNoninteractiveTabindex: what scrolls must be reached by keys */}
      <section class="scroll" aria-label="Budgets" tabIndex={0}>
        <table class="list budget">
          <thead>
            <tr>
              <th scope="col">From → to</th>
              <th scope="col">Class</th>
              <th scope="col" class="number">
                Worst case
              </th>
              <th scope="col" class="number">
                Measured
              </th>
            </tr>
          </thead>
          {[...links].sort(byLevel).map((link) => (
            <Link key={`${link.host} ${link.link}`} link={link} />
          ))}
        </table>
      </section>
    </div>
  );
}

const ranks: Record<Level, number> = { red: 0, yellow: 1, ok: 2 };
const words: Record<Level, string> = { red: 'too much', yellow: 'nearly full', ok: 'fits' };
const byLevel = (a: LinkBudget, b: LinkBudget) => ranks[a.level] - ranks[b.level];
const rate = (value: number | null | undefined) => (value == null ? '–' : `${bytes(value)}/s`);

function Link({ link }: { link: LinkBudget }) {
  const { rate_bytes_per_s: cap, reserve_percent: reserve } = link;
  return (
    <tbody>
      <tr class="sum">
        <th scope="rowgroup">
          {link.host} → {link.link}
          <span class="faint small">
            {cap === null ? 'no limit is set' : `${rate(cap)}${reserve ? `, ${reserve} % in reserve` : ''}`}
          </span>
          <Bars link={link} />
        </th>
        <td>all</td>
        <td class="number">{rate(link.worst_bytes_per_s)}</td>
        <td class="number">{rate(link.measured_bytes_per_s)}</td>
      </tr>
      {link.classes.map((each) => (
        <tr key={each.class}>
          <td />
          <td>{each.class}</td>
          <td class="number">
            {rate(each.worst_bytes_per_s)}
            {cap !== null && <span class="faint small"> {percent(each.worst_bytes_per_s / cap)}</span>}
          </td>
          <td class="number">{rate(each.measured_bytes_per_s)}</td>
        </tr>
      ))}
    </tbody>
  );
}

function Bars({ link: { worst_share: worst, measured_share: measured, level } }: { link: LinkBudget }) {
  if (worst == null) return null;
  return (
    <span class={`budget-bars level-${level}`}>
      <span class="bar-box" aria-hidden="true">
        <i class="worst" style={{ inlineSize: `${Math.min(100, 100 * worst)}%` }} />
        {measured != null && <i class="measured" style={{ inlineSize: `${Math.min(100, 100 * measured)}%` }} />}
      </span>
      <strong>{percent(worst)}</strong> {words[level]}
      {measured != null && <span class="faint"> (now {percent(measured)})</span>}
    </span>
  );
}
