// The texts as they shall be, beside those that are deployed; with undo and redo.

import { type Merge, merge } from './lines';
import type { Edit } from './protocol';

export interface Deployed {
  text: string;
  hash: string;
}

// "robot1:robots/scout.toml"
export type FileKey = string;

export const keyOf = (host: string, file: string): FileKey => `${host}:${file}`;
export const hostOf = (key: FileKey) => key.slice(0, key.indexOf(':'));
export const fileOf = (key: FileKey) => key.slice(key.indexOf(':') + 1);

// null: the file shall not be there.
type Changes = ReadonlyMap<FileKey, string | null>;

interface Step {
  label: string;
  changes: Changes;
}

export interface SavedDraft {
  bases: [FileKey, Deployed | null][];
  changes: [FileKey, string | null][];
}

const stepsMax = 200;

export class Draft {
  private deployed = new Map<FileKey, Deployed>();
  // What the changed files were when their change began; null: not there.
  private bases = new Map<FileKey, Deployed | null>();
  private now: Step = { label: '', changes: new Map() };
  private past: Step[] = [];
  private future: Step[] = [];

  // --- what there is

  get keys(): FileKey[] {
    const keys = new Set([...this.deployed.keys(), ...this.now.changes.keys()]);
    return [...keys].filter((key) => this.text(key) !== null).sort();
  }

  get changed(): FileKey[] {
    return [...this.now.changes.keys()].sort();
  }

  get undoLabel(): string | undefined {
    return this.past.length > 0 ? this.now.label : undefined;
  }

  get redoLabel(): string | undefined {
    return this.future.at(-1)?.label;
  }

  isChanged(key: FileKey): boolean {
    return this.now.changes.has(key);
  }

  // null: it is not there, or shall not be.
  text(key: FileKey): string | null {
    const changed = this.now.changes.get(key);
    return changed !== undefined ? changed : this.deployedText(key);
  }

  deployedText(key: FileKey): string | null {
    return this.deployed.get(key)?.text ?? null;
  }

  // The text that a change of it began with.
  baseText(key: FileKey): string | null {
    return (this.isChanged(key) ? this.bases.get(key)?.text : this.deployedText(key)) ?? null;
  }

  deployedHash(key: FileKey): string | undefined {
    return this.deployed.get(key)?.hash;
  }

  // --- changes

  // One step of undo, unless it goes on with the step of the same name (`again`), as typing does.
  change(label: string, texts: Iterable<[FileKey, string | null]>, again = false): void {
    const changes = new Map(this.now.changes);
    for (const [key, text] of texts) {
      if (!changes.has(key)) this.begin(key);
      if (text === (this.bases.get(key)?.text ?? null)) changes.delete(key);
      else changes.set(key, text);
    }
    if (sameChanges(changes, this.now.changes)) return;
    const goesOn = again && this.now.label === label && this.past.length > 0 && this.future.length === 0;
    if (!goesOn) this.past = [...this.past, this.now].slice(-stepsMax);
    this.future = [];
    this.now = { label, changes };
  }

  undo(): void {
    this.step(this.past, this.future);
  }

  redo(): void {
    this.step(this.future, this.past);
  }

  discard(): void {
    this.change(
      'Discard all changes',
      this.changed.map((key) => [key, this.bases.get(key)?.text ?? null]),
    );
  }

  private step(from: Step[], to: Step[]): void {
    const next = from.pop();
    if (next === undefined) return;
    to.push(this.now);
    this.now = next;
  }

  // Steps that began with a text that is not deployed any more cannot be gone back to.
  private begin(key: FileKey): void {
    const base = this.bases.get(key);
    if (base !== undefined && base?.hash !== this.deployedHash(key)) this.forget();
    this.bases.set(key, this.deployed.get(key) ?? null);
  }

  private forget(): void {
    this.past = [];
    this.future = [];
  }

  // --- what is on the hosts

  deploy(key: FileKey, file: Deployed | null): void {
    if (file === null) this.deployed.delete(key);
    else this.deployed.set(key, file);
    // Another editor, or our own change, has done the same.
    if (this.now.changes.get(key) === (file?.text ?? null)) this.settle(key);
  }

  // Changed here and, since then, by another editor.
  get conflicts(): FileKey[] {
    return this.changed.filter((key) => this.bases.get(key)?.hash !== this.deployedHash(key));
  }

  // Does our change on the text of the other editor. Undefined: the other one has removed the file, or we have.
  merge(key: FileKey): Merge | undefined {
    const ours = this.now.changes.get(key);
    const theirs = this.deployed.get(key);
    if (ours == null || theirs === undefined) return undefined;
    const merged = merge(this.bases.get(key)?.text ?? '', ours, theirs.text);
    this.rebase(key, merged.text);
    return merged;
  }

  // Ours instead of what the other editor made.
  keep(key: FileKey): void {
    this.rebase(key, this.now.changes.get(key) ?? null);
  }

  // The other editor's text; our change is given up.
  reload(key: FileKey): void {
    this.settle(key);
  }

  private rebase(key: FileKey, text: string | null): void {
    this.forget();
    this.bases.set(key, this.deployed.get(key) ?? null);
    const changes = new Map(this.now.changes);
    if (text === this.deployedText(key)) changes.delete(key);
    else changes.set(key, text);
    this.now = { label: '', changes };
  }

  private settle(key: FileKey): void {
    this.forget();
    this.bases.delete(key);
    const changes = new Map(this.now.changes);
    changes.delete(key);
    this.now = { label: '', changes };
  }

  // --- for the agents

  // Of one host: whole texts.
  edits(host: string): Edit[] {
    return this.changed.filter((key) => hostOf(key) === host).map((key) => this.edit(key));
  }

  edit(key: FileKey): Edit {
    const file = fileOf(key);
    const base = this.isChanged(key) ? (this.bases.get(key)?.hash ?? null) : (this.deployedHash(key) ?? null);
    const text = this.text(key);
    return text === null ? { file, base, remove: true } : { file, base, text };
  }

  // --- over a reload of the page

  save(): SavedDraft {
    return {
      bases: [...this.bases].filter(([key]) => this.isChanged(key)),
      changes: [...this.now.changes],
    };
  }

  restore({ bases, changes }: SavedDraft): void {
    this.bases = new Map(bases);
    this.now = { label: '', changes: new Map(changes) };
    this.forget();
  }
}

function sameChanges(a: Changes, b: Changes): boolean {
  return a.size === b.size && [...a].every(([key, text]) => b.has(key) && b.get(key) === text);
}
