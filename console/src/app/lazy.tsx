// A page whose script is loaded when it is opened for the first time.

import { signal } from '@preact/signals';
import type { ComponentType } from 'preact';

// `quiet`: a part of the frame; until it is loaded, it is not there.
export function lazy(load: () => Promise<ComponentType>, quiet = false): ComponentType {
  const page = signal<ComponentType | undefined>(undefined);
  const trouble = signal('');
  let begun = false;
  const begin = () => {
    begun = true;
    trouble.value = '';
    load().then(
      (loaded) => {
        page.value = loaded;
      },
      (error: Error) => {
        trouble.value = error.message;
      },
    );
  };
  return () => {
    if (!begun) begin();
    const Page = page.value;
    if (Page !== undefined) return <Page />;
    if (quiet) return null;
    if (trouble.value === '') return <p class="empty faint">Loading …</p>;
    return (
      <section class="empty" role="alert">
        <p>This page could not be loaded: {trouble.value}</p>
        <button type="button" onClick={begin}>
          Try again
        </button>
      </section>
    );
  };
}
