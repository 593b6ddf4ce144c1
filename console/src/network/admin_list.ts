// A list of the router, renewed at a period while it is shown.

import { useSignal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { useConsole } from '../app/console';
import { pageVisible } from '../ui/use_stream';

export function useAdminList<Item>(load: () => Promise<Item[]>, key: string, period = 2000) {
  const { client } = useConsole();
  const items = useSignal<Item[] | undefined>(undefined);
  const trouble = useSignal('');
  const visible = pageVisible.value;
  useEffect(() => {
    if (!visible) return;
    let ended = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const renew = async () => {
      try {
        const list = client.connection.value.state === 'connected' ? await load() : undefined;
        if (!ended && list !== undefined) items.value = list;
        trouble.value = '';
      } catch (error) {
        trouble.value = (error as Error).message;
      }
      if (!ended) timer = setTimeout(renew, period);
    };
    void renew();
    return () => {
      ended = true;
      clearTimeout(timer);
    };
  }, [key, period, visible]);
  return { items: items.value, trouble: trouble.value };
}
