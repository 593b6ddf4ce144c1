// Logging in and out, and what the login may do.

import { useSignal } from '@preact/signals';
import type { ComponentChildren } from 'preact';
import { useId } from 'preact/hooks';
import { hindrance, login, logOut, type Right } from '../tims/login';

export function LoginPage({ why }: { why: string }) {
  return (
    <main id="content" class="login">
      <section class="empty">
        <h1>Log in</h1>
        {why !== '' && (
          <p class="bad" role="alert">
            {why}
          </p>
        )}
        <p>On the host of this router, or as a user of the fleet on another one, run</p>
        <p>
          <code>timsctl web</code>
        </p>
        <p>and open the link that it prints: it works once, within 60 s.</p>
      </section>
    </main>
  );
}

export function LoginBadge() {
  const failed = useSignal(false);
  const { user, right } = login.value;
  if (user === '') return null;
  const leave = () =>
    logOut().catch(() => {
      failed.value = true;
    });
  return (
    <>
      <span class="badge" title={`You are ${user} and may ${right}`}>
        {user} <span class="faint">{right}</span>
      </span>
      <button type="button" class={failed.value ? 'bad' : ''} onClick={leave}>
        Log out
      </button>
    </>
  );
}

// Controls that need a right: without it they are disabled, and it says why.
export function Needs({ right, children }: { right: Right; children: ComponentChildren }) {
  const id = useId();
  const why = hindrance(right);
  if (why === '') return <>{children}</>;
  return (
    <fieldset class="needs" disabled aria-describedby={id}>
      <p id={id} class="notice">
        {why}
      </p>
      {children}
    </fieldset>
  );
}
