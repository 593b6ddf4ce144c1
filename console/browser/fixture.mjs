// Real programs and a real browser for the stories beside this file: a router that serves the built console, robots
// that `timsctl up` starts, and Debian's Chromium.
import assert from 'node:assert/strict';
import { execFile, spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { connect, createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

const root = fileURLToPath(new URL('../..', import.meta.url));
export const programs = process.env.TIMS_PROGRAMS ?? join(root, 'build/release/bin');
const consoleFolder = process.env.TIMS_CONSOLE; // in place of that of the programs' build
export const browserProgram = process.env.CHROMIUM ?? '/usr/bin/chromium-headless-shell';
const patience = 30_000; // ms; the machine may be busy

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

const sleep = (time) => new Promise((resolve) => setTimeout(resolve, time));

// Until the condition returns something, or throws for the last time.
export async function eventually(condition, what, time = patience) {
  let failure;
  for (const end = Date.now() + time; ; await sleep(50)) {
    try {
      const value = await condition();
      if (value) return value;
      failure = undefined;
    } catch (error) {
      failure = error;
    }
    if (Date.now() > end) assert.fail(`never happened: ${what}${failure ? `: ${failure.message}` : ''}`);
  }
}

// A base and robots with a link to it each, over UDP of this machine: [base, robot 1, robot 2, ...].
export async function startFleet(robots) {
  const port = await freePort();
  const base = await Host.start([
    'router.name=base',
    'router.role=top',
    'tcp.admin=true',
    'sim.faults=true',
    `udp.listen=127.0.0.1:${port}`,
    'link=kind=sub,system=*,interval=200ms',
  ]);
  const hosts = [base];
  for (let system = 1; system <= robots; ++system)
    hosts.push(
      await Host.start([
        `router.name=robot${system}`,
        `router.system=${system}`,
        'tcp.admin=true',
        'sim.faults=true',
        `udp.listen=127.0.0.1:${await freePort()}`,
        `link=kind=super,to=127.0.0.1:${port},interval=200ms`,
      ]),
    );
  return hosts;
}

export function freePort() {
  return new Promise((resolve, reject) => {
    const server = createServer();
    server.on('error', reject);
    server.listen(0, '127.0.0.1', () => {
      const { port } = server.address();
      server.close(() => resolve(port));
    });
  });
}

// One direction of a line: what several connections send shares its rate, and arrives later.
class Way {
  waiting = []; // { bytes, to, from }, one of each sender: it sends more when this has left
  flying = []; // { bytes, to, at }
  freeAt = 0;

  constructor(line) {
    this.line = line;
  }

  take(bytes, from, to) {
    from.pause();
    this.waiting.push({ bytes, from, to });
    this.go();
  }

  go() {
    clearTimeout(this.timer);
    const now = performance.now();
    const { rate, delay, isStalled } = this.line;
    if (isStalled) return;
    while (this.waiting.length > 0 && this.freeAt <= now) {
      const { bytes, from, to } = this.waiting.shift();
      this.freeAt = Math.max(this.freeAt, now - 1) + (1000 * bytes.length) / rate;
      this.flying.push({ bytes, to, at: this.freeAt + delay });
      from.resume();
    }
    while (this.flying.length > 0 && this.flying[0].at <= now) {
      const { bytes, to } = this.flying.shift();
      if (!to.destroyed) to.write(bytes);
    }
    const next = Math.min(this.waiting.length > 0 ? this.freeAt : Infinity, this.flying[0]?.at ?? Infinity);
    if (next < Infinity) this.timer = setTimeout(() => this.go(), next - now);
  }
}

// A line between a browser and a router that can be cut, stalled and slow.
export class Line {
  sockets = new Set();
  rate = Infinity; // bytes a second, in each direction
  delay = 0; // ms, in each direction
  isStalled = false;

  static start(port) {
    const line = new Line();
    const ways = [new Way(line), new Way(line)];
    line.ways = ways;
    line.server = createServer((near) => {
      if (line.isCut) return near.destroy();
      const far = connect(port, '127.0.0.1');
      for (const [from, to, way] of [
        [near, far, ways[0]],
        [far, near, ways[1]],
      ]) {
        line.sockets.add(from);
        from.on('error', () => {});
        from.on('close', () => {
          line.sockets.delete(from);
          to.destroy();
        });
        from.on('data', (bytes) => way.take(bytes, from, to));
      }
    });
    return new Promise((resolve) => line.server.listen(0, '127.0.0.1', () => resolve(line)));
  }

  get address() {
    return `http://127.0.0.1:${this.server.address().port}`;
  }

  cut() {
    this.isCut = true;
    for (const socket of this.sockets) socket.destroy();
  }

  mend() {
    this.isCut = false;
  }

  // Nothing is lost, but nothing arrives until it flows again.
  stall() {
    this.isStalled = true;
  }

  flow() {
    this.isStalled = false;
    for (const way of this.ways) way.go();
  }

  end() {
    this.cut();
    for (const way of this.ways) clearTimeout(way.timer);
    this.server.close();
  }
}

process.setMaxListeners(100);

// One host: its router, and what runs at it. Everything ends with end().
export class Host {
  folder = mkdtempSync(join(tmpdir(), 'console-browser-'));
  children = [];

  static async start(settings = []) {
    const host = new Host();
    host.settings = settings;
    host.http = await freePort();
    host.tcp = await freePort();
    await host.startRouter();
    return host;
  }

  get address() {
    return `http://127.0.0.1:${this.http}`;
  }

  async startRouter() {
    const settings = [
      `unix.path=${this.folder}/router.sock`,
      `tcp.listen=127.0.0.1:${this.tcp}`,
      `http.listen=127.0.0.1:${this.http}`,
      ...this.settings,
    ];
    if (consoleFolder !== undefined) settings.push(`http.console=${consoleFolder}`);
    if (!this.settings.some((setting) => setting.startsWith('udp.listen'))) settings.push('udp.listen=off');
    this.router = this.run(
      'tims-router',
      settings.flatMap((setting) => ['--set', setting]),
    );
    await eventually(async () => {
      if (this.router.exitCode !== null) throw new Error(this.router.output);
      return (await fetch(`${this.address}/healthz`)).ok;
    }, 'the router answers');
  }

  // A question to the router, as its TCP client.
  ask(question, port = this.tcp) {
    const adminRequest = 64;
    const body = Buffer.from(JSON.stringify(question));
    const header = Buffer.alloc(16);
    header.writeUInt8(3, 0); // little endian
    header.writeInt8(adminRequest, 1);
    header.writeUInt32LE(header.length + body.length, 12);
    return new Promise((resolve, reject) => {
      const socket = connect(port, '127.0.0.1', () => socket.write(Buffer.concat([header, body])));
      let answer = Buffer.alloc(0);
      socket.on('error', reject);
      socket.on('data', (part) => {
        answer = Buffer.concat([answer, part]);
        if (answer.length < 16 || answer.length < answer.readUInt32LE(12)) return;
        socket.destroy();
        const value = JSON.parse(answer.subarray(16));
        if (value.error === undefined) resolve(value);
        else reject(new Error(value.error.message));
      });
    });
  }

  async killRouter() {
    const ended = new Promise((resolve) => this.router.once('exit', resolve));
    this.router.kill('SIGKILL');
    await ended;
  }

  // A robot file of deploy/robots, changed by `edit`.
  async up(file, system, edit = (text) => text) {
    const text = edit(readFileSync(join(root, 'deploy/robots', file), 'utf8'));
    const name = join(this.folder, `${system}-${file}`);
    writeFileSync(
      name,
      text.replaceAll('"floor.dxf"', `"${join(root, 'deploy/robots/floor.dxf')}"`).replaceAll('../', `${root}/deploy/`),
    );
    const child = this.run('timsctl', ['up', name, '--system', `${system}`]);
    await eventually(() => child.output.includes('is up'), `robot ${system} is up`);
    return child;
  }

  run(program, args) {
    const child = spawn(join(programs, program), args, {
      env: { ...process.env, TIMS_ROUTER: `${this.folder}/router.sock`, TIMS_HOST: `unix:${this.folder}/router.sock` },
      stdio: ['ignore', 'pipe', 'pipe'],
    });
    child.output = '';
    const keep = (text) => {
      child.output = `${child.output}${text}`.slice(-100_000);
    };
    child.stdout.on('data', keep);
    child.stderr.on('data', keep);
    this.children.push(child);
    process.once('exit', () => child.kill('SIGTERM')); // also when a story has thrown
    return child;
  }

  // What another program sees of it.
  timsctl(...args) {
    return new Promise((resolve, reject) => {
      execFile(
        join(programs, 'timsctl'),
        ['-H', `unix:${this.folder}/router.sock`, '--json', ...args],
        (error, stdout, stderr) => {
          if (stdout === '') reject(error ?? new Error(stderr));
          else resolve(JSON.parse(stdout));
        },
      );
    });
  }

  async end() {
    for (const child of [...this.children].reverse()) {
      if (child.exitCode !== null || child.signalCode !== null) continue;
      const ended = new Promise((resolve) => child.once('exit', resolve));
      child.kill('SIGTERM');
      const timer = setTimeout(() => child.kill('SIGKILL'), 10_000);
      await ended;
      clearTimeout(timer); // a test file ends with its last timer
    }
    rmSync(this.folder, { recursive: true, force: true });
  }
}

// A browser that can be killed, with all its processes: [kills it, the browser].
export async function launchServer() {
  const server = await chromium.launchServer({ executablePath: browserProgram, args: ['--no-sandbox'] });
  const kill = () => process.kill(-server.process().pid, 'SIGKILL'); // the program is a script that starts the browser
  return [kill, await chromium.connect(server.wsEndpoint())];
}

export function launch(args = [], program = browserProgram) {
  return chromium.launch({ executablePath: program, args: ['--no-sandbox', ...args] });
}

// A page that fails the test when it logs an error, or asks somebody else than its router.
export class Watched {
  static left = new Set(); // that are open

  // For afterEach: what a story that failed has left behind would disturb those after it.
  static async closeAll() {
    for (const { context } of Watched.left) await context.close().catch(() => {});
    Watched.left.clear();
  }

  // `init`: what the page does before its own scripts.
  static async open(browser, host, path = '#/fleet', { init, ...options } = {}) {
    const watched = new Watched();
    watched.troubles = [];
    watched.context = await browser.newContext({ viewport: { width: 1440, height: 900 }, ...options });
    watched.page = await watched.context.newPage();
    if (init !== undefined) await watched.page.addInitScript(init);
    const { page, troubles } = watched;
    page.on('pageerror', (error) => troubles.push(`${error.message}\n${error.stack}`));
    page.on('console', (message) => message.type() === 'error' && troubles.push(message.text()));
    page.on('request', (request) => {
      const url = new URL(request.url());
      if (!['blob:', 'data:'].includes(url.protocol) && url.host !== new URL(host.address).host)
        troubles.push(`asks ${request.url()}`);
    });
    Watched.left.add(watched);
    await page.goto(`${host.address}/${path}`);
    return watched;
  }

  async close(ignored = []) {
    Watched.left.delete(this);
    await this.context.close();
    const troubles = this.troubles.filter((text) => !ignored.some((part) => text.includes(part)));
    assert.deepEqual(troubles, []);
  }
  // What axe finds on the page that is shown, as far as it is serious. `rules`: all, if it names none.
  async seriousFindings(rules = []) {
    this.tools ??= await this.context.newCDPSession(this.page); // the policy of the page forbids a script tag
    const isThere = await this.page.evaluate(() => globalThis.axe !== undefined);
    if (!isThere) await this.tools.send('Runtime.evaluate', { expression: axe });
    const violations = await this.page.evaluate(async (only) => {
      for (let i = 0; i < 2; ++i) await new Promise(requestAnimationFrame); // a change of the address is drawn
      const chosen = only.length === 0 ? {} : { runOnly: { type: 'rule', values: only } };
      return (await globalThis.axe.run({ resultTypes: ['violations'], ...chosen })).violations;
    }, rules);
    return violations
      .filter(({ impact }) => impact === 'serious' || impact === 'critical')
      .map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join(' ')}`);
  }
}
