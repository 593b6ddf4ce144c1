import { render } from 'preact';
import { App } from './app/app';
import { ConsoleContext, makeConsole } from './app/console';

// The build's name for tims/worker.ts.
const workerUrl = document.querySelector<HTMLMetaElement>('meta[name="worker"]')?.content ?? '';
const url = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/tims`;
const root = document.getElementById('app');
if (root !== null)
  render(
    <ConsoleContext.Provider value={makeConsole(new Worker(workerUrl, { type: 'module' }), url)}>
      <App />
    </ConsoleContext.Provider>,
    root,
  );
