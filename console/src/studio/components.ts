// The components of a robot file, and what their parameters are and shall be.

import { type FileKey, hostOf } from './draft';
import type { ParameterInfo, ProgramInfo, Toml, TomlTable } from './protocol';

export interface PlannedComponent {
  key: FileKey;
  host: string;
  index: number; // of [[component]] in its file
  path: string; // "component[2]"
  program: string; // "" for a command line
  command: string;
  instance: number;
  system: number;
  title: string; // "Scan2d/0", or its name
  on: string; // another computer, reached by ssh; "" for the host itself
  parameters: TomlTable;
}

export function componentsOf(key: FileKey, values: TomlTable | null | undefined, system = 0): PlannedComponent[] {
  const list = values?.component;
  if (!Array.isArray(list)) return [];
  const ownSystem = typeof values?.system === 'number' ? values.system : system;
  return list.flatMap((entry, index) => {
    if (!isTable(entry)) return [];
    const program = textOf(entry.program);
    const command = textOf(entry.command);
    const instance = typeof entry.instance === 'number' ? entry.instance : 0;
    return {
      key,
      host: hostOf(key),
      index,
      path: `component[${index}]`,
      program,
      command,
      instance,
      system: ownSystem,
      title:
        textOf(entry.name) || (program !== '' ? `${program}${instance > 0 ? `/${instance}` : ''}` : programIn(command)),
      on: textOf(entry.host),
      parameters: isTable(entry.parameters) ? entry.parameters : {},
    };
  });
}

const textOf = (value: Toml | undefined) => (typeof value === 'string' ? value : '');

export const isTable = (value: Toml | undefined): value is TomlTable =>
  typeof value === 'object' && value !== null && !Array.isArray(value);

// "World" of "nice -n -15 World --system=1"
export function programIn(command: string): string {
  const words = command.split(/\s+/).filter((word) => word !== '');
  return words.find((word) => !/^(-.*|\d+|nice|taskset|chrt|env|.*=.*)$/.test(word)) ?? 'command';
}

// "Scan2d(1/0)": what it is for others. Undefined: its program is not known.
export function addressNameOf(component: PlannedComponent, program: ProgramInfo | undefined): string | undefined {
  return program === undefined ? undefined : `${program.class}(${component.system}/${component.instance})`;
}

// --- parameters

export interface ParameterLine {
  info: ParameterInfo;
  path: string;
  file: string | undefined; // as written, with "{system}"
  usual: string; // the default
}

// In the order of the program; those of the file that it does not have come first.
export function parameterLines(component: PlannedComponent, program: ProgramInfo | undefined): ParameterLine[] {
  const known = (program?.parameters ?? []).filter(({ name, common }) => !common || !ofFile.includes(name));
  const names = new Set(known.map(({ name }) => name));
  const strange = Object.entries(component.parameters)
    .filter(([name]) => !names.has(name))
    .map(([name, value]): ParameterInfo => ({ name, type: typeOf(value), help: '' }));
  return [...strange, ...known].map((info) => ({
    info,
    path: `${component.path}.parameters.${info.name}`,
    file: valueText(component.parameters[info.name]),
    usual: info.default === undefined ? '' : `${info.default}`,
  }));
}

const ofFile = ['system', 'instance']; // keys of the file and of the component

function typeOf(value: Toml): ParameterInfo['type'] {
  if (typeof value !== 'number') return 'text';
  return Number.isInteger(value) ? 'int' : 'float';
}

export function valueText(value: Toml | undefined): string | undefined {
  if (value === undefined) return undefined;
  return typeof value === 'string' ? value : JSON.stringify(value);
}

// What is written in the file for what was typed. The agent refuses what does not fit; "{system}" and other texts
// stay texts.
export function tomlOf(text: string, type: ParameterInfo['type']): Toml {
  if (type === 'text') return text;
  const plain = text.trim().replace(',', '.');
  const number = Number(plain);
  return plain === '' || !Number.isFinite(number) ? text : number;
}

// The value with "{system}" filled in, as the program gets it.
export function resolved(text: string, system: number): string {
  return text.replaceAll('{system}', `${system}`);
}

// As numbers or as texts: 13 and 13.0 are the same.
export function sameValue(a: string, b: string): boolean {
  return a === b || (a.trim() !== '' && b.trim() !== '' && Number(a) === Number(b));
}

// "0 to 100 000 mm, now"
export function factsOf(info: ParameterInfo): string {
  const bounds =
    info.choices === undefined && info.min !== undefined && info.max !== undefined && info.max < 2147483647
      ? info.min > -2147483647
        ? `${info.min} to ${info.max}`
        : `at most ${info.max}`
      : '';
  const effect = { now: 'at once', on: 'at the next ON', start: 'at the next start' };
  return [
    bounds,
    info.refers !== undefined && `the ${info.part ?? 'address'} of its ${info.refers}`,
    info.takes_effect !== undefined && effect[info.takes_effect],
    info.required && 'must be set',
  ]
    .filter(Boolean)
    .join('; ');
}
