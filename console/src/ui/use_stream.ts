// The data of a component while a view is visible: a hidden tab, and a tile that is scrolled away, subscribe to nothing.

import { type ReadonlySignal, signal, useSignal } from '@preact/signals';
import { createContext, type RefObject } from 'preact';
import { useContext, useEffect, useMemo, useRef } from 'preact/hooks';
import { useConsole, widthsOf } from '../app/console';
import { decodeData } from '../codec/catalogue';
import type { DecodeOptions } from '../codec/struct';
import type { Component } from '../model/fleet';
import { fieldsOf } from '../tims/address';
import { decodeHeader, headerSize } from '../tims/header';

export interface StreamValue<Data> {
  data: Data;
  at: number; // performance.now()
  received: number;
  skipped: number;
}

export const defaultPeriod = 66; // ms
export const eachSample = 0; // as fast as the component makes them

// True while the tab is visible.
export const pageVisible = signal(!document.hidden);
document.addEventListener('visibilitychange', () => {
  pageVisible.value = !document.hidden;
});

// Whether the part of the page around a view is in sight.
export const InSight = createContext<ReadonlySignal<boolean>>(signal(true));

// False: nobody sees the view; it asks for nothing.
export function useVisible(): boolean {
  const inSight = useContext(InSight).value;
  return pageVisible.value && inSight;
}

// For a part of the page that may be scrolled away: [its element, whether it is in sight].
export function useInSight<Kind extends Element>(): [RefObject<Kind | null>, ReadonlySignal<boolean>] {
  const element = useRef<Kind>(null);
  const inSight = useSignal(false);
  useEffect(() => {
    if (element.current === null) return;
    const observer = new IntersectionObserver((entries) => {
      inSight.value = entries.at(-1)?.isIntersecting ?? false;
    });
    observer.observe(element.current);
    return () => observer.disconnect();
  }, []);
  return [element, inSight];
}

export interface Stream<Data> {
  value: ReadonlySignal<StreamValue<Data> | undefined>;
  trouble: ReadonlySignal<string | undefined>;
}

// `options`: a constant.
export function useStream<Data>(
  address: number | undefined,
  period = defaultPeriod,
  options?: DecodeOptions,
): Stream<Data> {
  const console = useConsole();
  return useDecoded(address, period, (body, flags, of) => {
    const { classId } = fieldsOf(of, widthsOf(console));
    return decodeData(classId, body, flags, options) as Data;
  });
}

// As they are, of a class that is not described.
export function useBytes(address: number, period = defaultPeriod): Stream<Uint8Array> {
  return useDecoded(address, period, (body) => body);
}

// `decode` throws why a body cannot be read.
function useDecoded<Data>(
  address: number | undefined,
  period: number,
  decode: (body: Uint8Array, flags: number, address: number) => Data,
): Stream<Data> {
  const console = useConsole();
  const value = useMemo(() => signal<StreamValue<Data> | undefined>(undefined), [address]);
  const trouble = useMemo(() => signal<string | undefined>(undefined), [address]);
  const visible = useVisible();
  useEffect(() => {
    if (address === undefined || !visible) return;
    return console.client.subscribe(address, period, (sample) => {
      const header = decodeHeader(sample.message);
      if (header === undefined) return;
      try {
        const data = decode(sample.message.subarray(headerSize), header.flags, address);
        value.value = { data, at: sample.at, received: sample.received, skipped: sample.skipped };
        trouble.value = undefined;
      } catch (error) {
        trouble.value = (error as Error).message;
      }
    });
  }, [address, period, visible]);
  return { value, trouble };
}

// What a component that is on is asked for at this period, one question at a time: for data that are smaller than its stream.
export function useAsked<Data>({ address, state }: Component, period: number, ask: () => Promise<Data>): Stream<Data> {
  const value = useMemo(() => signal<StreamValue<Data> | undefined>(undefined), [address]);
  const trouble = useMemo(() => signal<string | undefined>(undefined), [address]);
  const isAsked = useVisible() && state.value !== 'off';
  useEffect(() => {
    if (!isAsked) return;
    let ended = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const turn = async () => {
      try {
        const data = await ask();
        if (ended) return;
        value.value = { data, at: performance.now(), received: (value.peek()?.received ?? 0) + 1, skipped: 0 };
        trouble.value = undefined;
      } catch (error) {
        if (ended) return;
        trouble.value = (error as Error).message;
      }
      timer = setTimeout(turn, period);
    };
    void turn();
    return () => {
      ended = true;
      clearTimeout(timer);
    };
  }, [address, period, isAsked]);
  return { value, trouble };
}
