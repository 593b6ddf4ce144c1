// Logging in and out, and what the login may do.

import { useSignal } from '@preact/signals';
import { hindrance, login, logOut } from '../tims/login';
import { type Deed, neededFor } from './needs';

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

// Above controls that are disabled for this login: why, also for those who cannot point at them.
export function Hindrance({ deed }: { deed: Deed }) {
  const why = hindrance(neededFor(deed));
  return why === '' ? null : <p class="notice">{why}</p>;
}
