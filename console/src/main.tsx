import { render } from 'preact';
import { App } from './app/app';
import { ConsoleContext, makeConsole } from './app/console';
import { askLogin, logIn, login, tokenOf } from './tims/login';
import { LoginPage } from './ui/login';

// The build's name for tims/worker.ts.
const workerUrl = document.querySelector<HTMLMetaElement>('meta[name="worker"]')?.content ?? '';
const url = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/tims`;
const root = document.getElementById('app');

// The token leaves the address and the history before it is sent. Returns why the login failed.
async function takeToken(): Promise<string> {
  const token = tokenOf(location.hash);
  if (token === undefined) return '';
  history.replaceState(null, '', '#/fleet');
  dispatchEvent(new HashChangeEvent('hashchange'));
  try {
    await logIn(token);
    return '';
  } catch (error) {
    return (error as Error).message;
  }
}

async function start(at: HTMLElement): Promise<void> {
  // A link may be opened in this tab, also while it shows the console.
  addEventListener('hashchange', () => tokenOf(location.hash) !== undefined && location.reload());
  const why = await takeToken();
  if (why === '' && !location.hash.startsWith('#/login/')) await askLogin();
  if (why !== '' || login.value.right === 'none') {
    render(<LoginPage why={why} />, at);
    return;
  }
  render(
    <ConsoleContext.Provider value={makeConsole(new Worker(workerUrl, { type: 'module' }), url)}>
      <App />
    </ConsoleContext.Provider>,
    at,
  );
  // A login that ends, here or elsewhere, leaves nothing on the page.
  login.subscribe(({ right }) => right === 'none' && location.reload());
}

if (root !== null) void start(root);
