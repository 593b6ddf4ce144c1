// Bundles the console into a folder that the router serves: names with hashes, compressed forms, and
// the licences of what is bundled. Two builds of the same sources give the same bytes.
//
//   node build.mjs FOLDER [--install] [--optional]
//
// --install: runs `npm ci` first if package-lock.json has changed since. --optional: when that fails,
// reports it and builds nothing, so that a machine without network still builds the router.
import { spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { existsSync, mkdirSync, readdirSync, readFileSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { brotliCompressSync, constants, gzipSync } from 'node:zlib';

const here = dirname(fileURLToPath(import.meta.url));

// Bytes of script, compressed with brotli: what the first page loads, and all of it.
export const BUDGET = { first: 60_000, all: 250_000 };
const BROTLI = { params: { [constants.BROTLI_PARAM_QUALITY]: 10 } };
const COMPRESSED = /\.(js|css|html|svg|json|txt|webmanifest)$/;

// The page, and the worker that it starts at once: it finds its name in a <meta>, so that both are built
// together and share what they have in common.
const PAGE = 'src/main.tsx';
const WORKER = 'src/tims/worker.ts';
const STYLE = 'src/app/style.css';

// Asked for by these names: a browser keeps the manifest, and the icon of an app that was installed.
const NAMED = ['app.webmanifest', 'icon.svg'];

export async function build(folder, budget = BUDGET) {
  const { build: bundle } = await import('esbuild');
  const { metafile, outputFiles } = await bundle({
    absWorkingDir: here,
    entryPoints: [PAGE, WORKER, STYLE],
    outdir: 'dist',
    write: false,
    bundle: true,
    splitting: true,
    minify: true,
    format: 'esm',
    target: 'es2022',
    jsx: 'automatic',
    jsxImportSource: 'preact',
    entryNames: '[name]-[hash]',
    chunkNames: '[name]-[hash]',
    assetNames: '[name]-[hash]',
    legalComments: 'linked',
    metafile: true,
    logLevel: 'warning',
  });
  const files = new Map(outputFiles.map((file) => [file.path.slice(join(here, 'dist/').length), file.contents]));
  const outputs = new Map(
    Object.entries(metafile.outputs).map(([path, output]) => [path.replace(/^dist\//, ''), output]),
  );
  files.set('index.html', Buffer.from(page(outputs)));
  for (const name of NAMED) files.set(name, readFileSync(join(here, 'src', name)));
  files.set('licences.txt', Buffer.from(licences(metafile)));
  const sizes = check(files, outputs, budget);
  write(folder, files);
  return sizes;
}

// --- the page

function entry(outputs, source) {
  return [...outputs].find(([, output]) => output.entryPoint === source);
}

// An output and all that it imports when it is loaded.
function withImports(outputs, path, found = new Set()) {
  if (found.has(path)) return found;
  found.add(path);
  for (const { path: other, kind } of outputs.get(path).imports)
    if (kind === 'import-statement') withImports(outputs, other.replace(/^dist\//, ''), found);
  return found;
}

function page(outputs) {
  const [main] = entry(outputs, PAGE);
  const [worker] = entry(outputs, WORKER);
  const [style] = entry(outputs, STYLE);
  const head = [`<meta name="worker" content="/${worker}">`, `<link rel="stylesheet" href="/${style}">`];
  for (const path of withImports(outputs, main))
    if (path !== main) head.push(`<link rel="modulepreload" href="/${path}">`);
  head.push(`<script type="module" src="/${main}"></script>`);
  return readFileSync(join(here, 'src/index.html'), 'utf8').replace('<!-- scripts -->', head.join('\n    '));
}

// --- licences

function licences(metafile) {
  const inputs = Object.keys(metafile.inputs);
  const names = inputs.flatMap((path) => path.match(/^node_modules\/((?:@[^/]+\/)?[^/]+)\//)?.[1] ?? []);
  const texts = [...new Set(names)].sort().map((name) => {
    const folder = join(here, 'node_modules', name);
    const { version, license } = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
    const file = readdirSync(folder).find((other) => /^licen[cs]e/i.test(other));
    if (!file) throw new Error(`${name} has no text of its licence`);
    return `${name} ${version} (${license})\n\n${readFileSync(join(folder, file), 'utf8')}`;
  });
  return `The console contains:\n\n${texts.join('\n\n')}`;
}

// --- sizes

function brotli(bytes) {
  return brotliCompressSync(bytes, BROTLI);
}

function check(files, outputs, budget) {
  const scripts = [...files.keys()].filter((path) => path.endsWith('.js'));
  const sizes = new Map(scripts.map((path) => [path, brotli(files.get(path)).length]));
  const sum = (paths) => paths.reduce((total, path) => total + sizes.get(path), 0);
  const first = new Set([PAGE, WORKER].flatMap((source) => [...withImports(outputs, entry(outputs, source)[0])]));
  const found = { first: sum([...first]), all: sum(scripts) };
  for (const what of ['first', 'all'])
    if (found[what] > budget[what]) {
      const list = [...sizes].sort((a, b) => b[1] - a[1]).map(([path, size]) => `  ${size} ${path}`);
      throw new Error(
        `the scripts of ${what === 'first' ? 'the first page' : 'the console'} have ${found[what]} bytes, ` +
          `at most ${budget[what]} are allowed (brotli):\n${list.join('\n')}`,
      );
    }
  return found;
}

// --- output

// A compressed form that is not smaller is left out.
function forms(path, bytes) {
  if (!COMPRESSED.test(path)) return [['', bytes]];
  const compressed = [
    ['.br', brotli(bytes)],
    ['.gz', gzipSync(bytes, { level: 9 })],
  ];
  return [['', bytes], ...compressed.filter(([, form]) => form.length < bytes.length)];
}

// The folder is replaced as a whole: files of an earlier build go.
function write(folder, files) {
  const made = `${folder}.new`;
  rmSync(made, { recursive: true, force: true });
  for (const [path, bytes] of files) {
    mkdirSync(dirname(join(made, path)), { recursive: true });
    for (const [ending, form] of forms(path, bytes)) writeFileSync(join(made, path + ending), form);
  }
  rmSync(folder, { recursive: true, force: true });
  renameSync(made, folder);
}

// --- packages

// False when they could not be installed.
function install() {
  const hash = createHash('sha256')
    .update(readFileSync(join(here, 'package-lock.json')))
    .digest('hex');
  const mark = join(here, 'node_modules/.installed');
  if (existsSync(mark) && readFileSync(mark, 'utf8') === hash) return true;
  const npm = spawnSync('npm', ['ci', '--no-audit', '--no-fund'], {
    cwd: here,
    stdio: ['ignore', 'inherit', 'inherit'],
  });
  if (npm.status !== 0) return false;
  writeFileSync(mark, hash);
  return true;
}

async function main([folder, ...options]) {
  if (!folder || folder.startsWith('-')) throw new Error('usage: node build.mjs FOLDER [--install] [--optional]');
  if (options.includes('--install') && !install()) {
    const text = 'npm ci failed, see above: the router is built without its console';
    if (!options.includes('--optional')) throw new Error(text);
    console.warn(`console: ${text}. With a network, build again; or -DTIMS_WITH_CONSOLE=OFF`);
    return;
  }
  const { first, all } = await build(resolve(folder));
  console.log(`console: ${first} bytes of script in the first page, ${all} in all (brotli)`);
}

if (process.argv[1] === fileURLToPath(import.meta.url))
  main(process.argv.slice(2)).catch((error) => {
    console.error(`console: ${error.message}`);
    process.exitCode = 1;
  });
