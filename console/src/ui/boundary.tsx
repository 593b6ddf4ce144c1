// What keeps a failure to the part of the page in which it happened.

import type { ComponentChildren } from 'preact';
import { useErrorBoundary } from 'preact/hooks';

interface Properties {
  what: 'page' | 'view';
  children: ComponentChildren;
}

// Shows why its children could not be drawn, in their place.
export function Boundary({ what, children }: Properties) {
  const [failure, retry] = useErrorBoundary();
  if (failure === undefined) return <>{children}</>;
  const Heading = what === 'page' ? 'h1' : 'h3';
  return (
    <section class={what === 'page' ? 'empty' : ''} role="alert">
      <Heading>This {what} has failed</Heading>
      <p>{String(failure?.message ?? failure)}</p>
      <button type="button" onClick={retry}>
        Try again
      </button>
    </section>
  );
}
