// Times of day, in the zone of whoever looks or in UTC: a switch on each page that shows times.

import { computed, signal } from '@preact/signals';

const stored = 'rack.utc';
const chosen = signal(localStorage.getItem(stored) === '1');

interface Formats {
  zone: string; // "Europe/Berlin"
  time: Intl.DateTimeFormat;
  day: Intl.DateTimeFormat;
}

function formatsOf(timeZone?: string): Formats {
  const time = new Intl.DateTimeFormat('en-GB', { timeStyle: 'medium', timeZone });
  const day = new Intl.DateTimeFormat('en-GB', { dateStyle: 'medium', timeZone });
  return { zone: time.resolvedOptions().timeZone, time, day };
}

const localZone = new Intl.DateTimeFormat().resolvedOptions().timeZone;
const shown = computed(() => formatsOf(chosen.value ? 'UTC' : undefined)); // when asked: it takes 30 ms

// "14:03:01"; on another day "26 Nov 2026 14:03:01".
export function timeText(time: Date, now = new Date()): string {
  const { day, time: ofDay } = shown.value;
  return day.format(time) === day.format(now) ? ofDay.format(time) : dateText(time);
}

export function dateText(time: Date): string {
  const { day, time: ofDay } = shown.value;
  return `${day.format(time)} ${ofDay.format(time)}`;
}

export function UtcSwitch() {
  if (localZone === 'UTC') return null;
  const choose = () => {
    chosen.value = !chosen.value;
    localStorage.setItem(stored, chosen.value ? '1' : '0');
  };
  return (
    <button type="button" aria-pressed={chosen.value} title={`Times are those of ${shown.value.zone}`} onClick={choose}>
      UTC
    </button>
  );
}
