// The numbers of a message that can be plotted: its own fields and those of its structs, in SI units. Pure.

import type { Field, Fields } from '../codec/struct';

export interface NumberField {
  name: string; // "pos.x"
  path: string[];
  unit: string;
  factor: number;
}

export function numberFields(fields: readonly Field[], path: string[] = []): NumberField[] {
  return fields.flatMap((field) => {
    if (field.isVariable || field.times !== undefined || field.type === 'count' || field.type === 'time') return [];
    const here = [...path, field.name];
    if (field.inner !== undefined) return numberFields(field.inner.fields, here);
    if (field.number === undefined) return [];
    return [{ name: here.join('.'), path: here, unit: field.si_unit ?? '', factor: field.si ?? 1 }];
  });
}

export function numberAt(data: Fields, { path, factor }: NumberField): number | undefined {
  let value: unknown = data;
  for (const name of path) value = (value as Fields | undefined)?.[name];
  if (typeof value === 'bigint') return Number(value) * factor;
  return typeof value === 'number' && Number.isFinite(value) ? value * factor : undefined;
}
