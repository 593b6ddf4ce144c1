// The layouts that somebody keeps in this browser: names of addresses of pages. They leave it and come back as a file.

import { signal } from '@preact/signals';
import { type Imported, importGuiCfg, type Layout } from './gui_cfg';

const stored = 'rack.layouts';
const format = 'rack/layouts/1';
const layoutsMax = 200;

export const layouts = signal<Layout[]>(read(localStorage.getItem(stored)));

export function keepLayout(layout: Layout): void {
  store([...layouts.value.filter(({ name }) => name !== layout.name), layout]);
}

export function removeLayout(name: string): void {
  store(layouts.value.filter((layout) => layout.name !== name));
}

export function layoutsFile(): string {
  return `${JSON.stringify({ format, layouts: layouts.value }, null, 2)}\n`;
}

// A file of this console, or a gui.cfg of the original.
export function importLayouts(text: string): Imported {
  const imported = text.trimStart().startsWith('{') ? { layouts: read(text, true), remarks: [] } : importGuiCfg(text);
  for (const layout of imported.layouts) keepLayout(layout);
  return imported;
}

function store(next: Layout[]): void {
  layouts.value = next.slice(-layoutsMax);
  localStorage.setItem(stored, layoutsFile());
}

function read(text: string | null, strict = false): Layout[] {
  try {
    const file = JSON.parse(text ?? '{}');
    if (file.format !== format) throw new Error('this is no file of layouts');
    return (file.layouts as unknown[]).filter(isLayout).slice(-layoutsMax);
  } catch (error) {
    if (strict) throw error;
    return [];
  }
}

// An address within the console, so that a file cannot lead elsewhere.
function isLayout(value: unknown): value is Layout {
  const { name, address } = value as Partial<Layout>;
  return typeof name === 'string' && typeof address === 'string' && address.startsWith('#/');
}
