// How fast a robot moves, and how long it takes to stand: at most 0.3 s until it brakes, and the time that braking takes.
import assert from 'node:assert/strict';
import { eventually } from './fixture.mjs';

const reaction = 300; // ms
const period = 100; // ms, of the chassis' data: it may stand for as long before a sample says so
const braking = 500; // mm/s², decMax of ChassisSim
const still = 1; // mm/s
const look = 10; // ms

export class Speed {
  samples = []; // { at, speed }: ms, mm/s
  rest = '';

  constructor(host, chassis) {
    this.host = host;
    this.chassis = chassis;
  }

  // The stream of the chassis ends when it is turned off.
  follow() {
    if (this.program !== undefined && this.program.exitCode === null) return;
    this.rest = '';
    this.program = this.host.run('timsctl', ['--json', 'msg', 'echo', this.chassis]);
    this.program.stdout.on('data', (text) => this.take(text));
  }

  take(text) {
    const lines = `${this.rest}${text}`.split('\n');
    this.rest = lines.pop();
    for (const { time, data } of lines.map((line) => JSON.parse(line)))
      if (data !== undefined) this.samples.push({ at: Date.parse(time), speed: Math.abs(data.vx) });
  }

  drives() {
    const begin = Date.now();
    return eventually(() => {
      this.follow();
      return this.samples.some(({ at, speed }) => at > begin && speed > 50);
    }, 'it drives');
  }

  // Does what is to stop it. A machine that is busy with something else is late itself: by how much is measured beside
  // it, and granted.
  async stopsBy(what, action) {
    const begin = Date.now();
    let late = 0;
    let before = begin;
    const timer = setInterval(() => {
      late = Math.max(late, Date.now() - before - look);
      before = Date.now();
    }, look);
    try {
      await action();
      const since = () => this.samples.filter(({ at }) => at > begin);
      await eventually(() => since().at(-1)?.speed < still, `it stands: ${what}`);
      const samples = since();
      const last = this.samples.findLast(({ at }) => at <= begin);
      const most = Math.max(last?.speed ?? 0, ...samples.map(({ speed }) => speed));
      const took = samples.find(({ speed }) => speed < still).at - begin;
      const limit = reaction + (1000 * most) / braking + period + late;
      console.log(`${what}: from ${most} mm/s it stands after ${took} ms (limit ${Math.round(limit)}, late ${late})`);
      assert(took <= limit, `${what}: it stands after ${took} ms, from ${most} mm/s`);
    } finally {
      clearInterval(timer);
    }
  }
}
