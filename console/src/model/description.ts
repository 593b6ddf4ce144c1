// What a component states about itself: its parameters with units, ranges and meanings. It is asked for page by page;
// components of the original have none.

import { decodeStruct } from '../codec/catalogue';
import { bytesOf, textOf } from '../codec/text';
import type { Client } from '../tims/client';
import { command } from './commands';

export interface ParameterDescription {
  name: string;
  type: 'int' | 'float' | 'text';
  default?: string | number;
  help: string;
  min?: number;
  max?: number;
  unit?: string;
  choices?: { value: number | string; meaning?: string }[];
  refers?: string; // the class of a partner
  takes_effect?: 'now' | 'on' | 'start';
  host_file?: boolean;
  common?: boolean;
}

export interface Description {
  program: string;
  purpose: string;
  parameters: ParameterDescription[];
}

const sizeMax = 1 << 20;

export async function describe(client: Client, component: { address: number }): Promise<Description | undefined> {
  const bytes: number[] = [];
  for (;;) {
    const offset = bytes.length;
    const answer = await command(client, component, 'GET_DESCRIPTION', { offset, bytesMax: 0 }).catch(() => undefined);
    if (answer === undefined) return undefined;
    const page = decodeStruct('DescriptionPage', answer.body, answer.flags);
    const text = bytesOf(page.text);
    if (page.offset !== offset || text.length === 0 || page.size > sizeMax) return undefined;
    bytes.push(...text);
    if (bytes.length >= page.size) break;
  }
  const description = JSON.parse(textOf(Uint8Array.from(bytes)));
  return description.rack_description === 1 ? description : undefined;
}
