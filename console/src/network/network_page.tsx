// The routers of the fleet and the links between them: what is broken, and why a message does not arrive.

import { route, setOption } from '../app/route';
import { Events } from './events';
import { ExplainForm } from './explain_form';
import { Links } from './links';
import { Routers } from './routers';
import { TraceForm } from './trace_form';

const tabs = [
  ['routers', 'Routers', Routers],
  ['links', 'Links', Links],
  ['explain', 'Explain', ExplainForm],
  ['trace', 'Trace', TraceForm],
  ['events', 'Events', Events],
] as const;

export function NetworkPage() {
  const chosen = route.value.options.get('tab') ?? 'routers';
  const [, , View] = tabs.find(([name]) => name === chosen) ?? tabs[0];
  return (
    <section>
      <div class="tools">
        <h1>Network</h1>
        <div role="tablist" aria-label="Views of the network" class="tabs">
          {tabs.map(([name, title]) => (
            <button
              key={name}
              type="button"
              role="tab"
              aria-selected={chosen === name}
              onClick={() => setOption('tab', name)}
            >
              {title}
            </button>
          ))}
        </div>
      </div>
      <View />
    </section>
  );
}
