// What configuration agents answer, as far as the page uses it (tools/configuration/PROTOCOL.md).

import type { Description, ParameterDescription } from '../model/description';

export type Toml = string | number | boolean | null | Toml[] | TomlTable;

export interface TomlTable {
  [key: string]: Toml;
}

export interface HostList {
  host: string;
  folder: string;
  router: { name: string; address: string; system: number; id: number; role: string };
  generation: number;
  files: ListedFile[];
  change: HostState;
}

export interface ListedFile {
  file: string;
  kind: 'router' | 'robot';
  bytes: number;
  hash: string;
  robot?: string;
  system?: number;
  running?: boolean;
}

// [line, column] of each value by its path; both from 1.
export type Places = Record<string, [number, number]>;

export interface FileText {
  file: string;
  kind: 'router' | 'robot';
  text: string;
  hash: string;
  values: TomlTable | null;
  places: Places;
}

export interface Operation {
  op: 'set' | 'add' | 'remove';
  path: string;
  value?: Toml;
}

// `base`: the hash of the text that was edited; null: there was no such file.
export interface Edit {
  file: string;
  base: string | null;
  text?: string;
  operations?: Operation[];
  remove?: boolean;
}

export interface Problem {
  host?: string;
  file: string;
  line: number; // 0: without a place
  column?: number;
  path?: string;
  severity: 'error' | 'warning';
  text: string;
}

export interface CheckedFile {
  file: string;
  hash: string | null;
  text: string | null;
  added: number;
  removed: number;
  diff: string;
  sentences: string[];
  values?: TomlTable | null;
  places?: Places;
}

export interface Effect {
  what: string;
  file: string;
  does: 'reload' | 'restart' | 'start' | 'stop' | 'none';
  ok?: boolean;
  text?: string;
}

export interface Check {
  ok: boolean;
  problems: Problem[];
  files: CheckedFile[];
  effects: Effect[];
}

export interface DataEdge {
  from: string;
  to: string;
  host: string;
  to_host: string | null;
  parameter: string;
  period_ms: number | null;
  bytes_max: number | null;
}

export type Level = 'ok' | 'yellow' | 'red';

export interface LinkBudget {
  host: string;
  router: string;
  link: string;
  rate_bytes_per_s: number | null;
  reserve_percent: number | null;
  classes: { class: number; worst_bytes_per_s: number; measured_bytes_per_s?: number | null }[];
  worst_bytes_per_s: number;
  worst_share: number | null;
  measured_bytes_per_s: number | null;
  measured_share: number | null;
  level: Level;
}

export interface FleetCheck {
  ok: boolean;
  problems: Problem[];
  order: string[];
  edges: DataEdge[];
  links: LinkBudget[];
}

export interface HostState {
  host: string;
  generation: number;
  state: 'idle' | 'locked' | 'applying' | 'waiting' | 'settling' | 'going_back';
  change?: string | null;
  who?: string;
  why?: string;
  left_s?: number;
  window_s?: number;
  window_min_s?: number; // the least that may be asked for
  others?: string[];
  done?: Effect[];
  last?: { generation: number; change: string; outcome: Outcome; reason?: string; time: string } | null;
}

export type Outcome = 'pending' | 'confirmed' | 'went_back' | 'found';

export interface HistoryItem {
  generation: number;
  time: string;
  who: string;
  why: string;
  change: string;
  outcome: Outcome;
  reason?: string;
  files: { file: string; hash: string }[];
}

export interface Generation extends Omit<HistoryItem, 'files'> {
  files: { file: string; hash: string; text: string }[];
}

// One key of a router file.
export interface RouterOption {
  key: string;
  list?: boolean;
  kind: string; // "number", "true or false", "role", ...
  range?: string; // "0 to 65535"; of an enumeration its values: "subsystem, system, top"
  default?: string;
  reload?: boolean;
  help: string;
}

export interface InstalledProgram {
  program: string;
  purpose: string;
  class: string;
}

export interface ParameterInfo extends ParameterDescription {
  part?: 'system' | 'instance';
  required?: boolean;
}

export interface ProgramInfo extends Description {
  class: string | number;
  class_id: number;
  parameters: ParameterInfo[];
}
