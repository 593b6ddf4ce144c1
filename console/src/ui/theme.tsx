// Light or dark: as the system wants it, until somebody chooses.

import { effect, signal } from '@preact/signals';
import { Icon } from './icons';

type Theme = 'light' | 'dark';

const stored = 'rack.theme';
const system = matchMedia('(prefers-color-scheme: dark)');
const chosen = signal<Theme | undefined>((localStorage.getItem(stored) as Theme | null) ?? undefined);
const systemIsDark = signal(system.matches);
system.addEventListener('change', () => {
  systemIsDark.value = system.matches;
});

export const isDark = () => (chosen.value === undefined ? systemIsDark.value : chosen.value === 'dark');

effect(() => {
  document.documentElement.dataset.theme = isDark() ? 'dark' : 'light';
});

export function ThemeSwitch() {
  const next: Theme = isDark() ? 'light' : 'dark';
  const choose = () => {
    chosen.value = next;
    localStorage.setItem(stored, next);
  };
  return (
    <button
      type="button"
      class="quiet"
      onClick={choose}
      aria-label={`Use ${next} colours`}
      title={`Use ${next} colours`}
    >
      <Icon name={isDark() ? 'sun' : 'moon'} />
    </button>
  );
}
