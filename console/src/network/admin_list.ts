// A list of the router, renewed at a period while it is shown. A load that takes long may publish what it has by then:
// it is shown as long as there is no whole list: soon, and then ever less often, since each showing of a long list delays
// its end.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { useConsole } from '../app/console';
import { pageVisible } from '../ui/use_stream';

const firstPause = 100; // ms

// With another `key` the former items are shown until the new ones come: a list of another router needs a component of
// its own.
export function useAdminList<Item>(
  load: (publish: (part: () => Item[]) => void) => Promise<Item[]>,
  key: string,
  period = 2000,
) {
  const { client } = useConsole();
  const items = useSignal<Item[] | undefined>(undefined);
  const trouble = useSignal('');
  const visible = pageVisible.value;
  const connected = client.connection.value.state === 'connected';
  useEffect(() => {
    if (!visible || !connected) return;
    let ended = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    let isWhole = items.value !== undefined;
    let showing: ReturnType<typeof setTimeout> | undefined;
    let pause = firstPause;
    const publish = (part: () => Item[]) => {
      if (showing !== undefined || isWhole) return;
      showing = setTimeout(() => {
        showing = undefined;
        if (!isWhole) items.value = part();
      }, pause);
      pause *= 2;
    };
    const renew = async () => {
      try {
        const list = await load(publish);
        if (!ended) {
          isWhole = true;
          items.value = list;
        }
        if (!ended) trouble.value = '';
      } catch (error) {
        if (!ended) trouble.value = (error as Error).message;
      }
      if (!ended) timer = setTimeout(renew, period);
    };
    void renew();
    return () => {
      ended = true;
      clearTimeout(timer);
      clearTimeout(showing);
    };
  }, [key, period, visible, connected]);
  return { items: items.value, trouble: trouble.value };
}
