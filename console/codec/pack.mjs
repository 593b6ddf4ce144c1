// Packs the codec for npm: node codec/pack.mjs FOLDER writes FOLDER/rack-codec-VERSION.tgz. Nothing is fetched.
import { spawnSync } from 'node:child_process';
import { cpSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const here = fileURLToPath(new URL('.', import.meta.url));
const root = join(here, '..');

function run(program, ...options) {
  const { status, stdout, stderr, error } = spawnSync(program, options, { encoding: 'utf8' });
  if (status !== 0) throw new Error(`${program} ${options.join(' ')}: ${error ?? stdout + stderr}`);
  return stdout;
}

// Node asks for the whole names of files.
function nameFiles(folder) {
  for (const path of readdirSync(folder, { recursive: true })) {
    if (!path.endsWith('.d.ts')) continue;
    const file = join(folder, path);
    writeFileSync(file, readFileSync(file, 'utf8').replace(/(from\s+'\.[^']*)'/g, "$1.js'"));
  }
}

export async function pack(folder) {
  const stage = mkdtempSync(join(tmpdir(), 'rack-codec-'));
  try {
    const source = join(root, 'src/codec_package.ts');
    await build({
      entryPoints: [source],
      outfile: join(stage, 'index.js'),
      bundle: true,
      format: 'esm',
      target: 'es2022',
    });
    const tsc = join(root, 'node_modules/.bin/tsc');
    run(tsc, '-p', join(here, 'tsconfig.json'), '--outDir', join(stage, 'types'));
    nameFiles(join(stage, 'types'));
    for (const name of ['package.json', 'README.md']) cpSync(join(here, name), join(stage, name));
    cpSync(join(root, '../LICENSE'), join(stage, 'LICENSE'));
    mkdirSync(folder, { recursive: true });
    const packed = run('npm', 'pack', stage, '--pack-destination', folder, '--silent', '--offline').trim();
    return join(folder, packed.split('\n').at(-1));
  } finally {
    rmSync(stage, { recursive: true });
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  if (process.argv.length !== 3) {
    console.error('usage: node codec/pack.mjs FOLDER');
    process.exit(2);
  }
  console.log(await pack(resolve(process.argv[2])));
}
