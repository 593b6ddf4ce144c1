// The build itself: node --test build.test.mjs
import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { brotliDecompressSync, gunzipSync } from 'node:zlib';
import { BUDGET, build } from './build.mjs';

const folder = mkdtempSync(join(tmpdir(), 'console-build-'));
const first = join(folder, 'first');
const second = join(folder, 'second');
let sizes;
let files = [];

const list = (path) => readdirSync(path, { recursive: true }).sort();

before(async () => {
  sizes = await build(first);
  files = list(first).filter((path) => statSync(join(first, path)).isFile());
});
after(() => rmSync(folder, { recursive: true }));

const read = (path) => readFileSync(join(first, path));
const plain = () => files.filter((path) => !/\.(br|gz)$/.test(path));

test('a second build gives the same bytes, at the limit of their number, and replaces what was there', async () => {
  mkdirSync(second);
  writeFileSync(join(second, 'old.js'), '');
  await build(second, sizes);
  assert.deepEqual(list(second), list(first));
  for (const path of files) assert.deepEqual(readFileSync(join(second, path)), read(path), path);
});

test('too many bytes of script are refused with their names, and the build before is kept', async () => {
  assert.ok(sizes.first <= BUDGET.first && sizes.all <= BUDGET.all);
  for (const what of ['first', 'all'])
    await assert.rejects(build(second, { ...sizes, [what]: sizes[what] - 1 }), /main-\w{8}\.js/);
  assert.deepEqual(list(second), list(first));
});

test('the router accepts the files: 64 of them, 4 MiB with their compressed forms, plain names', () => {
  assert.ok(plain().length <= 64);
  assert.ok(files.reduce((sum, path) => sum + read(path).length, 0) <= 4 << 20);
  for (const path of files) assert.match(path, /^\w[\w.-]*(\/\w[\w.-]*)*$/);
});

const named = ['app.webmanifest', 'icon.svg'];

test('who installs it as an app finds its icon', () => {
  for (const { src } of JSON.parse(read('app.webmanifest')).icons) assert.ok(named.includes(src.slice(1)), src);
});

test('the page loads files of the build with a hash, and has nothing inline', () => {
  const html = read('index.html').toString();
  const loaded = [...html.matchAll(/(?:src|href|content)="\/([^"]*)"/g)].map((match) => match[1]);
  assert.ok(loaded.length >= 2);
  for (const path of loaded) {
    assert.ok(files.includes(path), path);
    if (!named.includes(path)) assert.match(path, /-[A-Z0-9]{8}\.(js|css)$/);
  }
  assert.doesNotMatch(html, /<script(?![^>]* src=)|<style|style="| on\w+="|https?:\/\//);
});

test('compressed forms contain the file', () => {
  for (const path of plain()) {
    if (files.includes(`${path}.br`)) assert.deepEqual(brotliDecompressSync(read(`${path}.br`)), read(path));
    if (files.includes(`${path}.gz`)) assert.deepEqual(gunzipSync(read(`${path}.gz`)), read(path));
  }
  assert.ok(files.some((path) => path.endsWith('.js.br')));
  const gzipped = files.find((path) => path.endsWith('.gz'));
  assert.equal(read(gzipped).readUInt32LE(4), 0, 'no time in it');
});

test('the licences of what is bundled are there', () => {
  assert.match(read('licences.txt').toString(), /^preact \d.*MIT/m);
});
