// Hosts as they are installed: a router with its file, which is started again when it ends, as a service is; the
// configuration agent; and robots from files in the same folder.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { eventually, freePort, Host } from './fixture.mjs';

// After which a change goes back at the earliest, in s: stories wait for it.
export const leastWindow = 6;

export class ConfiguredHost extends Host {
  ended = false;

  // `text`: of router.toml, beside what the test needs. `robots`: texts by file name.
  static async start(name, text, robots = {}) {
    const host = new ConfiguredHost();
    host.name = name;
    host.http = await freePort();
    host.tcp = await freePort();
    mkdirSync(`${host.files}/robots`, { recursive: true });
    mkdirSync(host.state);
    const console = process.env.TIMS_CONSOLE ? `console = "${process.env.TIMS_CONSOLE}"\n` : '';
    host.write(
      'router.toml',
      `# The router of ${name}.
[unix]
path = "${host.folder}/router.sock"

[tcp]
listen = "127.0.0.1:${host.tcp}"
admin = true   # the console may change this host

[http]
listen = "127.0.0.1:${host.http}"
${console}
${text}`,
    );
    for (const [file, robot] of Object.entries(robots)) host.write(`robots/${file}`, robot);
    await host.startRouter();
    await host.startAgent();
    return host;
  }

  get files() {
    return join(this.folder, 'etc');
  }

  get state() {
    return join(this.folder, 'state');
  }

  read(file) {
    return readFileSync(join(this.files, file), 'utf8');
  }

  write(file, text) {
    writeFileSync(join(this.files, file), text);
  }

  async startRouter() {
    const run = () => {
      this.router = this.run('tims-router', ['--config', join(this.files, 'router.toml')]);
      this.router.once('exit', () => !this.ended && setTimeout(run, 100));
    };
    run();
    await eventually(async () => (await fetch(`${this.address}/healthz`)).ok, `the router of ${this.name} answers`);
  }

  async startAgent() {
    this.agent = this.run('tims-agent', [
      `--folder=${this.files}`,
      `--state=${this.state}`,
      `--least-window=${leastWindow}s`,
    ]);
    await eventually(() => this.agent.output.includes('answers as'), `the agent of ${this.name} answers`);
  }

  async killAgent() {
    const ended = new Promise((resolve) => this.agent.once('exit', resolve));
    this.agent.kill('SIGKILL');
    await ended;
  }

  async upFile(file, system) {
    const child = this.run('timsctl', ['up', join(this.files, 'robots', file), '--system', `${system}`]);
    await eventually(() => child.output.includes('is up'), `${file} is up`);
  }

  async end() {
    this.ended = true;
    await super.end();
  }
}
