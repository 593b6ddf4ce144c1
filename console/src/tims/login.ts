// Who uses this page, and what it may do: look, drive or configure. A router without keys, and one on this machine,
// asks nobody. The router checks every message; what is refused there is not offered here.

import { signal } from '@preact/signals';
import { order, type Right } from './rights';

export interface Login {
  user: string; // empty: nobody was asked
  right: Right;
}

export const login = signal<Login>({ user: '', right: 'configure' });

export const may = (right: Right) => order.indexOf(login.value.right) >= order.indexOf(right);

// Why something is not possible, as a sentence; empty: it is.
export const hindrance = (right: Right) =>
  may(right) ? '' : `Your login may only ${login.value.right}: this needs the right to ${right}.`;

async function answered(response: Response): Promise<Login> {
  if (!response.ok) throw new Error((await response.text()).trim());
  return (await response.json()) as Login;
}

// As whom the router knows this page. A router that does not answer is not there: that is shown anyway.
export async function askLogin(): Promise<void> {
  try {
    login.value = await answered(await fetch('/login', { cache: 'no-store' }));
  } catch {}
}

// Throws why not, as a sentence.
export async function logIn(token: string): Promise<void> {
  login.value = await answered(
    await fetch('/login', {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify({ token }),
    }),
  );
}

export async function logOut(): Promise<void> {
  await fetch('/logout', { method: 'POST' });
  login.value = { user: '', right: 'none' };
}

// "#/login/TOKEN", as timsctl web prints it.
export const tokenOf = (hash: string) => /^#\/login\/([0-9a-f]{32})$/.exec(hash)?.[1];
