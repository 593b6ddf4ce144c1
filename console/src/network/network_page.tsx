// The routers of the fleet and the links between them: what is broken, and why a message does not arrive.

import { go, route } from '../app/route';
import { Clients } from './clients';
import { Events } from './events';
import { ExplainForm } from './explain_form';
import { Links } from './links';
import { Mailboxes } from './mailboxes';
import { Routers } from './routers';
import { TraceForm } from './trace_form';

const tabs = [
  ['routers', 'Routers', Routers],
  ['links', 'Links', Links],
  ['mailboxes', 'Mailboxes', Mailboxes],
  ['clients', 'Clients', Clients],
  ['explain', 'Explain', ExplainForm],
  ['trace', 'Trace', TraceForm],
  ['events', 'Events', Events],
] as const;

// The tabs are steps of the browser's history; each begins without the filter of the others.
function showTab(name: string) {
  const options = new URLSearchParams(route.value.options);
  options.set('tab', name);
  options.delete('filter');
  go({ ...route.value, options });
}

export function NetworkPage() {
  const chosen = route.value.options.get('tab') ?? 'routers';
  const [, , View] = tabs.find(([name]) => name === chosen) ?? tabs[0];
  return (
    <section>
      <div class="tools">
        <h1>Network</h1>
        <div role="tablist" aria-label="Views of the network" class="tabs">
          {tabs.map(([name, title]) => (
            <button key={name} type="button" role="tab" aria-selected={chosen === name} onClick={() => showTab(name)}>
              {title}
            </button>
          ))}
        </div>
      </div>
      <View />
    </section>
  );
}
