// The configuration of the fleet while it is edited: the files of all hosts, the draft of changes, what the agents say
// about it, and changes that are under way.

import { computed, type ReadonlySignal, type Signal, signal } from '@preact/signals';
import type { AdminError } from '../model/admin';
import type { Client } from '../tims/client';
import { type Agents, addressAsText, type FoundHost } from './agents';
import { newChangeId } from './apply';
import { Changes } from './changes';
import { componentsOf, type PlannedComponent } from './components';
import { Draft, type FileKey, fileOf, hostOf, keyOf } from './draft';
import type { Merge } from './lines';
import type {
  Check,
  FileText,
  FleetCheck,
  Generation,
  HistoryItem,
  HostList,
  HostState,
  InstalledProgram,
  Operation,
  Places,
  Problem,
  ProgramInfo,
  RouterOption,
  TomlTable,
} from './protocol';
import { cutComponent, pasteComponent, retype } from './text';

export interface Host extends FoundHost {
  list: HostList | undefined; // the last one; undefined: it has no agent
  trouble: string; // why there is none now
}

// What is in a text. While it cannot be read, the values are those before.
export interface Parsed {
  text: string;
  values: TomlTable;
  places: Places;
}

export interface FileOperations {
  key: FileKey;
  operations: Operation[];
}

const saved = 'rack.studio';
const typingTime = 400; // ms without a key before a text is checked
const stepTime = 1500; // ms without a key that end a step of undo
const refreshTime = 3000;
const changeTime = 1000; // while a change is under way
const hostsTime = 12_000;

export class Studio {
  readonly hosts: Signal<Host[]> = signal([]);
  readonly loaded = signal(false);
  readonly draft = new Draft();
  // Grows with each change of the draft, or of what is deployed.
  readonly revision = signal(0);
  readonly parsed: Signal<ReadonlyMap<FileKey, Parsed>> = signal(new Map());
  readonly checks: Signal<ReadonlyMap<string, Check>> = signal(new Map());
  readonly fleet: Signal<FleetCheck | undefined> = signal(undefined);
  readonly programs: Signal<ReadonlyMap<string, ProgramInfo | undefined>> = signal(new Map());
  readonly options: Signal<RouterOption[]> = signal([]);
  readonly failure = signal('');
  readonly checking = signal(false);
  readonly changes = new Changes({
    ask: (host, question) => this.ask<HostState>(host, question),
    reconnect: () => this.client.reconnect(),
    pause: (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds)),
  });

  private jobs: Promise<unknown> = Promise.resolve();
  private checkTimer: ReturnType<typeof setTimeout> | undefined;
  private checkNumber = 0;
  private asked = new Set<string>();
  private typedAt = Number.NEGATIVE_INFINITY;
  private hostsAt = Number.NEGATIVE_INFINITY;

  constructor(
    private readonly client: Client,
    private readonly agents: Agents,
  ) {
    const text = sessionStorage.getItem(saved);
    if (text !== null) this.draft.restore(JSON.parse(text));
  }

  // --- views of it

  readonly components: ReadonlySignal<PlannedComponent[]> = computed(() =>
    [...this.parsed.value]
      .filter(([key]) => fileOf(key).startsWith('robots/') && this.draft.text(key) !== null)
      .sort(([a], [b]) => (a < b ? -1 : 1))
      .flatMap(([key, { values }]) => componentsOf(key, values)),
  );

  readonly problems: ReadonlySignal<Problem[]> = computed(() => [
    ...[...this.checks.value].flatMap(([host, { problems }]) => problems.map((problem) => ({ ...problem, host }))),
    ...(this.fleet.value?.problems ?? []),
  ]);

  readonly changed: ReadonlySignal<FileKey[]> = computed(() => {
    void this.revision.value;
    return this.draft.changed;
  });

  // Of hosts whose files were read.
  readonly conflicts: ReadonlySignal<FileKey[]> = computed(() => {
    void this.revision.value;
    return this.draft.conflicts.filter((key) => this.host(hostOf(key))?.list !== undefined);
  });

  programOf(component: PlannedComponent): ProgramInfo | undefined {
    return this.programs.value.get(`${component.host}:${component.program}`);
  }

  // Hosts whose agents answer.
  get answering(): Host[] {
    return this.hosts.value.filter(({ list, trouble }) => list !== undefined && trouble === '');
  }

  host(name: string): Host | undefined {
    return this.hosts.value.find((host) => host.name === name);
  }

  // --- reading

  // While it is looked at: at a period, and as soon as the router is there. Returns what ends it.
  watch(): () => void {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let ended = false;
    let busy = false;
    const turn = async () => {
      clearTimeout(timer);
      if (busy) return;
      busy = true;
      if (!document.hidden && this.client.connection.value.state === 'connected')
        await this.refresh().catch((error: Error) => this.fail(error));
      busy = false;
      if (!ended) timer = setTimeout(turn, this.changes.isBusy ? changeTime : refreshTime);
    };
    const leave = this.client.connection.subscribe(() => void turn());
    return () => {
      ended = true;
      leave();
      clearTimeout(timer);
    };
  }

  async refresh(): Promise<void> {
    const now = performance.now();
    if (now >= this.hostsAt + hostsTime || this.hosts.value.length === 0) {
      this.hostsAt = now;
      const found = await this.agents.hosts();
      const known = new Map(this.hosts.value.map((host) => [host.router, host]));
      const here = new Set(found.map(({ router }) => router));
      const away = this.hosts.value.filter(({ router, list }) => !here.has(router) && list !== undefined);
      this.hosts.value = [
        ...found.map((host) => ({ list: known.get(host.router)?.list, trouble: '', ...host })),
        ...away, // shown as they were
      ];
    }
    const lists = await Promise.all(this.hosts.value.map((host) => this.list(host)));
    this.hosts.value = lists;
    const changed = await Promise.all(lists.map((host) => this.readFiles(host)));
    this.followChanges();
    this.loaded.value = true;
    if (changed.some(Boolean)) {
      ++this.revision.value;
      this.checkSoon(0, true);
    }
    void this.describePrograms();
    if (this.options.value.length === 0) await this.loadOptions(lists);
  }

  private async list(host: Host): Promise<Host> {
    try {
      return { ...host, list: await this.agents.ask<HostList>(host.agent, { ask: 'conf_list' }, 4000), trouble: '' };
    } catch (error) {
      const { code, message } = error as AdminError;
      const trouble = code !== 'no_answer' ? message : host.list ? 'it cannot be reached' : 'no configuration agent';
      return { ...host, trouble };
    }
  }

  // True: one of its files has changed.
  private async readFiles({ name, agent, list, trouble }: Host): Promise<boolean> {
    if (list === undefined || trouble !== '') return false;
    const before = this.draft.keys.filter((key) => hostOf(key) === name && this.draft.deployedHash(key) !== undefined);
    const listed = new Set(list.files.map(({ file }) => keyOf(name, file)));
    const gone = before.filter((key) => !listed.has(key));
    for (const key of gone) this.draft.deploy(key, null);
    const fresh = list.files.filter(({ file, hash }) => this.draft.deployedHash(keyOf(name, file)) !== hash);
    const read = new Map<FileKey, Parsed>();
    await Promise.all(
      fresh.map(async ({ file }) => {
        const { text, hash, values, places } = await this.agents.ask<FileText>(agent, { ask: 'conf_get', file });
        const key = keyOf(name, file);
        this.draft.deploy(key, { text, hash });
        if (this.draft.isChanged(key)) return;
        read.set(key, { text, values: values ?? this.parsed.value.get(key)?.values ?? {}, places });
      }),
    );
    // Other hosts are read at the same time: what they have brought meanwhile stays.
    const parsed = new Map([...this.parsed.value, ...read]);
    for (const key of gone) if (!this.draft.isChanged(key)) parsed.delete(key);
    this.parsed.value = parsed;
    return gone.length + fresh.length > 0;
  }

  private async describePrograms(): Promise<void> {
    const wanted = this.components.value.filter(({ program }) => program !== '');
    for (const { host, program } of wanted) {
      const key = `${host}:${program}`;
      const agent = this.host(host)?.agent;
      if (this.asked.has(key) || agent === undefined) continue;
      this.asked.add(key);
      const info = await this.agents.ask<ProgramInfo>(agent, { ask: 'conf_describe', program }).catch(() => undefined);
      this.programs.value = new Map([...this.programs.value, [key, info]]);
    }
  }

  // All programs of a host; it may take several questions until all have described themselves: `found` is called with
  // those that have.
  async installedPrograms(host: string, found: (programs: InstalledProgram[]) => void): Promise<void> {
    for (;;) {
      const question = { ask: 'conf_programs' };
      const { items, complete } = await this.ask<{ items: InstalledProgram[]; complete: boolean }>(host, question);
      found(items);
      if (complete) return;
    }
  }

  private async loadOptions(hosts: Host[]): Promise<void> {
    const host = hosts.find(({ list, trouble }) => list !== undefined && trouble === '');
    if (host === undefined) return;
    this.options.value = (await this.agents.ask<{ items: RouterOption[] }>(host.agent, { ask: 'conf_options' })).items;
  }

  // --- editing

  type(key: FileKey, edited: string): void {
    const text = this.draft.text(key) ?? '';
    const now = performance.now();
    const goesOn = now < this.typedAt + stepTime;
    this.typedAt = now;
    this.draft.change(`Edit ${fileOf(key)}`, [[key, retype(text, edited)]], goesOn);
    this.touched(typingTime);
  }

  // Values and tables are changed by the agents, which leave all other bytes as they are.
  operate(label: string, list: FileOperations[]): Promise<boolean> {
    return this.inTurn(async () => {
      const texts: [FileKey, string | null][] = [];
      for (const { key, operations } of list) {
        const host = hostOf(key);
        const edit = this.draft.edit(key);
        if (!this.draft.isChanged(key)) delete edit.text;
        const check = await this.ask<Check>(host, { ask: 'conf_check', edits: [{ ...edit, operations }] });
        const file = check.files.find((each) => each.file === edit.file);
        texts.push([key, file === undefined ? this.draft.baseText(key) : file.text]); // not listed: not changed
      }
      this.draft.change(label, texts);
      this.touched(0);
    });
  }

  // Its lines with their comments, from one robot file into another one.
  move(component: PlannedComponent, target: FileKey, system: number): Promise<boolean> {
    return this.inTurn(async () => {
      await this.check();
      const from = this.parsed.value.get(component.key);
      const text = this.draft.text(component.key);
      if (from === undefined || text === null || from.text !== text)
        throw new Error(`${fileOf(component.key)} has errors: mend them first`);
      const cut = cutComponent(text, from.places, component.index);
      if (cut === undefined) throw new Error(`${component.title} is not found in ${fileOf(component.key)}`);
      const head = this.draft.text(target) ?? newRobotFile(target, system);
      this.draft.change(`Move ${component.title} from ${component.host} to ${hostOf(target)}`, [
        [component.key, cut.rest],
        [target, pasteComponent(head, cut.block)],
      ]);
      this.touched(0);
    });
  }

  undo(): void {
    this.draft.undo();
    this.touched(0);
  }

  redo(): void {
    this.draft.redo();
    this.touched(0);
  }

  discard(): void {
    this.draft.discard();
    this.touched(0);
  }

  // Texts of an older generation, or of a file, as a change.
  propose(label: string, texts: [FileKey, string | null][]): void {
    this.draft.change(label, texts);
    this.touched(0);
  }

  merge(key: FileKey): Merge | undefined {
    const merged = this.draft.merge(key);
    this.touched(0);
    return merged;
  }

  keep(key: FileKey): void {
    this.draft.keep(key);
    this.touched(0);
  }

  reload(key: FileKey): void {
    this.draft.reload(key);
    this.touched(0);
  }

  private touched(wait: number): void {
    sessionStorage.setItem(saved, JSON.stringify(this.draft.save()));
    this.failure.value = '';
    ++this.revision.value;
    this.checkSoon(wait);
  }

  // --- checks

  private checkSoon(wait: number, all = false): void {
    clearTimeout(this.checkTimer);
    this.checkAll ||= all;
    this.checking.value = true;
    this.checkTimer = setTimeout(() => void this.check().catch((error: Error) => this.fail(error)), wait);
  }

  private checkAll = true;

  // Every host whose files have changed since; then all of them together.
  async check(measured = false): Promise<void> {
    const number = ++this.checkNumber;
    const current = () => number === this.checkNumber;
    clearTimeout(this.checkTimer);
    this.checking.value = true;
    const all = this.checkAll;
    try {
      const hosts = this.answering;
      const conflicts = new Set(this.draft.conflicts.map(hostOf));
      const checks = new Map(this.checks.value);
      const parsed = new Map(this.parsed.value);
      for (const { name } of hosts) {
        const edits = this.draft.edits(name);
        if (conflicts.has(name)) continue; // told by a notice of its own
        if (edits.length === 0 && !all && checks.get(name)?.files.length === 0) continue;
        const check = await this.ask<Check>(name, { ask: 'conf_check', edits });
        if (!current()) return;
        checks.set(name, edits.length === 0 ? { ...check, files: [] } : check);
        for (const { file, text, values, places } of check.files) {
          const key = keyOf(name, file);
          if (text === null || this.draft.text(key) === null) parsed.delete(key);
          else if (values != null && !isUnreadable(check, file, values))
            parsed.set(key, { text, values, places: places ?? {} });
        }
      }
      await this.reparse(parsed);
      if (!current()) return;
      this.checkAll = false;
      this.checks.value = checks;
      this.parsed.value = parsed;
      await this.checkFleet(measured, current);
      void this.describePrograms();
    } finally {
      if (current()) this.checking.value = false;
    }
  }

  // Files that are as deployed again, after an undo.
  private async reparse(parsed: Map<FileKey, Parsed>): Promise<void> {
    for (const key of this.draft.keys) {
      const text = this.draft.text(key);
      if (this.draft.isChanged(key) || parsed.get(key)?.text === text) continue;
      const file = await this.ask<FileText>(hostOf(key), { ask: 'conf_get', file: fileOf(key) }).catch(() => undefined);
      if (file?.text === text && file.values != null)
        parsed.set(key, { text: file.text, values: file.values, places: file.places });
    }
    for (const key of parsed.keys()) if (this.draft.text(key) === null) parsed.delete(key);
  }

  private async checkFleet(measured: boolean, current: () => boolean): Promise<void> {
    const hosts = this.hosts.value.filter(({ list }) => list !== undefined);
    const able = this.answering;
    const first = able.find(({ router }) => router === this.client.connection.value.router?.address) ?? able[0];
    if (first === undefined) return;
    const files = (name: string) =>
      this.draft.keys
        .filter((key) => hostOf(key) === name)
        .map((key) => ({ file: fileOf(key), text: this.draft.text(key) }));
    const fleet = await this.ask<FleetCheck>(first.name, {
      ask: 'conf_fleet',
      hosts: hosts.map(({ name }) => ({ host: name, files: files(name) })),
      measured,
    });
    if (!current()) return;
    if (!measured) keepMeasured(fleet, this.fleet.value);
    this.fleet.value = fleet;
  }

  // The budgets with what the routers measure now.
  measure(): Promise<boolean> {
    return this.inTurn(() => this.checkFleet(true, () => true));
  }

  // --- changing the hosts

  apply(who: string, why: string, window: number): Promise<boolean> {
    return this.inTurn(async () => {
      await this.check();
      const error = this.problems.value.find(({ severity }) => severity === 'error');
      if (error !== undefined) throw new Error(`${placeOf(error)}: ${error.text}`);
      const { changed } = this.draft;
      const hosts = [...new Set(changed.map(hostOf))];
      const change = {
        id: newChangeId(),
        who,
        why,
        window,
        edits: new Map(hosts.map((host) => [host, this.draft.edits(host)])),
        agents: new Map(this.hosts.value.map(({ name, agent }) => [name, addressAsText(agent)])),
        order: this.fleet.value?.order ?? [],
      };
      await this.changes
        .begin(
          change,
          changed.map((key) => [key, this.draft.text(key)]),
        )
        .finally(() => this.refresh().catch(() => {}));
    });
  }

  keepChange(id: string): Promise<boolean> {
    return this.inTurn(async () => {
      await this.changes.keep(id);
      await this.refresh();
    });
  }

  undoChange(id: string): Promise<boolean> {
    return this.inTurn(async () => {
      await this.changes.undo(id);
      await this.refresh();
    });
  }

  // What went back is offered again.
  private followChanges(): void {
    const offered = this.changes.follow(this.answering.map(({ name, list }) => ({ ...list!.change, host: name })));
    if (offered.length > 0) this.propose('The change that went back', offered);
  }

  // --- history

  async history(): Promise<{ host: string; items: HistoryItem[] }[]> {
    const hosts = this.answering;
    return Promise.all(
      hosts.map(async ({ name }) => ({
        host: name,
        items: (await this.ask<{ items: HistoryItem[] }>(name, { ask: 'conf_history' })).items,
      })),
    );
  }

  // The files of older generations become the draft: checked, compared and applied as any other change.
  goBackTo(label: string, generations: { host: string; generation: number }[]): Promise<boolean> {
    return this.inTurn(async () => {
      const texts: [FileKey, string | null][] = [];
      for (const { host, generation } of generations) {
        const { files } = await this.ask<Generation>(host, { ask: 'conf_generation', generation });
        const then = new Map(files.map(({ file, text }) => [keyOf(host, file), text]));
        for (const key of this.draft.keys) if (hostOf(key) === host && !then.has(key)) texts.push([key, null]);
        texts.push(...then);
      }
      this.propose(label, texts);
    });
  }

  // --- errands

  private ask<Answer>(name: string, question: { ask: string } & Record<string, unknown>): Promise<Answer> {
    const host = this.host(name);
    if (host === undefined) return Promise.reject(new Error(`${name} is not there`));
    return this.agents.ask<Answer>(host.agent, question);
  }

  // One after the other. False: it failed, and why is shown.
  private inTurn(job: () => Promise<void>): Promise<boolean> {
    const done = this.jobs.then(job).then(
      () => true,
      (error: Error) => {
        this.fail(error);
        return false;
      },
    );
    this.jobs = done;
    return done;
  }

  private fail(error: Error): void {
    const { hint } = error as AdminError;
    this.failure.value = `${error.message}${hint ? `; ${hint}` : ''}`;
  }
}

// "robots/scout.toml:12", with the host if it is known.
export function placeOf({ host, file, line }: Problem): string {
  return `${host === undefined ? '' : `${host}: `}${file}${line > 0 ? `:${line}` : ''}`;
}

// Of a text with an error of syntax no value is known: those before are shown on.
function isUnreadable({ problems }: Check, file: string, values: TomlTable): boolean {
  return (
    Object.keys(values).length === 0 &&
    problems.some((problem) => problem.file === file && problem.severity === 'error')
  );
}

function newRobotFile(target: FileKey, system: number): string {
  const name = fileOf(target).replace(/^robots\/|\.toml$/g, '');
  return `name = "${name}"\nsystem = ${system}\n`;
}

// An answer without measurements keeps those that were made before.
function keepMeasured(fleet: FleetCheck, before: FleetCheck | undefined): void {
  for (const link of fleet.links) {
    const old = before?.links.find(({ host, link: name }) => host === link.host && name === link.link);
    if (old === undefined || link.measured_bytes_per_s != null) continue;
    link.measured_bytes_per_s = old.measured_bytes_per_s;
    link.measured_share = old.measured_share;
    for (const each of link.classes)
      each.measured_bytes_per_s ??=
        old.classes.find((other) => other.class === each.class)?.measured_bytes_per_s ?? null;
  }
}
