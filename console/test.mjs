// Bundles the tests beside the sources and runs them: node test.mjs [PART OF A PATH]...
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const sources = fileURLToPath(new URL('src/', import.meta.url));
const wanted = process.argv.slice(2);
const tests = readdirSync(sources, { recursive: true })
  .filter((path) => /\.test\.tsx?$/.test(path) && (wanted.length === 0 || wanted.some((part) => path.includes(part))))
  .map((path) => join(sources, path));
if (tests.length === 0) {
  console.error(`no test in ${sources} has ${wanted.join(' or ')} in its path`);
  process.exit(2);
}

const folder = mkdtempSync(join(tmpdir(), 'console-test-'));
try {
  const { metafile } = await build({
    entryPoints: tests,
    outdir: folder,
    outbase: sources,
    outExtension: { '.js': '.mjs' },
    bundle: true,
    metafile: true,
    format: 'esm',
    platform: 'node',
    target: 'node18',
    jsx: 'automatic',
    jsxImportSource: 'preact',
    sourcemap: 'inline',
    logLevel: 'warning',
  });
  const bundles = Object.keys(metafile.outputs);
  const run = spawnSync(process.execPath, ['--enable-source-maps', '--test', ...bundles], {
    stdio: 'inherit',
    cwd: fileURLToPath(new URL('.', import.meta.url)),
  });
  process.exitCode = run.status ?? 1;
} finally {
  rmSync(folder, { recursive: true });
}
