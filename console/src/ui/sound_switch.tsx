// Lets one hear a number while one looks elsewhere.

import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { CheckBox } from './check_box';
import { Tone } from './tone';

interface Properties {
  label: string;
  frequency: number; // Hz
  isHeard: boolean;
}

export function SoundSwitch({ label, frequency, isHeard }: Properties) {
  const sounds = useSignal(false);
  const tone = useRef<Tone | undefined>(undefined);
  useEffect(() => {
    if (!sounds.value) return;
    tone.current = new Tone();
    return () => tone.current?.end();
  }, [sounds.value]);
  useEffect(() => {
    if (sounds.value) tone.current?.play(frequency, isHeard);
  }, [frequency, isHeard, sounds.value]);
  return <CheckBox checked={sounds}>{label}</CheckBox>;
}
