// The foot of the page: what is wrong, with the way to its line, what has changed, and the way to apply it.

import { useSignal } from '@preact/signals';
import { Icon } from '../ui/icons';
import { hostOf } from './draft';
import { show, showProblem } from './place';
import type { Problem } from './protocol';
import { placeOf, type Studio } from './studio';
import { useStudio } from './workshop';

export function StatusBar() {
  const { studio } = useStudio();
  const open = useSignal(false);
  const problems = sorted(studio.problems.value);
  const errors = problems.filter(({ severity }) => severity === 'error').length;
  const changed = studio.changed.value.length;
  return (
    <footer class="studio-status">
      {open.value && problems.length > 0 && (
        <ul class="problems" id="studio-problems" aria-label="Problems">
          {problems.map((problem) => (
            <ProblemLine key={`${placeOf(problem)} ${problem.text}`} problem={problem} />
          ))}
        </ul>
      )}
      <div class="actions">
        <button
          type="button"
          class={`quiet ${errors > 0 ? 'bad' : ''}`}
          aria-expanded={open.value}
          aria-controls="studio-problems"
          disabled={problems.length === 0}
          onClick={() => (open.value = !open.value)}
        >
          {problems.length > 0 && <Icon name="warning" />}{' '}
          <span aria-live="polite">{summary(studio, errors, problems)}</span>
        </button>
        <span class="grow" />
        {changed > 0 && <span class="changed-hosts">{changesText(studio)}</span>}
        <button type="button" class="primary" disabled={changed === 0} onClick={() => show({ view: 'changes' })}>
          {changed === 0 ? 'Nothing to apply' : 'Review and apply'}
        </button>
      </div>
    </footer>
  );
}

export function ProblemLine({ problem }: { problem: Problem }) {
  return (
    <li class={problem.severity === 'error' ? 'bad' : 'warn'}>
      <button type="button" class="quiet" onClick={() => showProblem(problem)}>
        <Icon name="warning" /> {placeOf(problem)}
      </button>
      <span>
        {problem.severity === 'warning' && 'Warning: '}
        {problem.text}
      </span>
    </li>
  );
}

function sorted(problems: Problem[]): Problem[] {
  const rank = ({ severity }: Problem) => (severity === 'error' ? 0 : 1);
  return [...problems].sort((a, b) => rank(a) - rank(b));
}

function summary(studio: Studio, errors: number, problems: Problem[]): string {
  if (studio.checking.value) return 'Checking …';
  const warnings = problems.length - errors;
  if (problems.length === 0) return studio.fleet.value === undefined ? 'Not checked yet' : 'No problems';
  const count = (number: number, what: string) => (number === 1 ? `1 ${what}` : `${number} ${what}s`);
  return [errors > 0 && count(errors, 'error'), warnings > 0 && count(warnings, 'warning')].filter(Boolean).join(', ');
}

// "main +3 −1, arm +1"
function changesText(studio: Studio): string {
  const hosts = [...new Set(studio.changed.value.map(hostOf))];
  return hosts
    .map((host) => {
      const files = studio.checks.value.get(host)?.files ?? [];
      const sum = (what: 'added' | 'removed') => files.reduce((total, file) => total + file[what], 0);
      return `${host} +${sum('added')} −${sum('removed')}`;
    })
    .join(', ');
}
