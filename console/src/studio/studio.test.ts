import assert from 'node:assert/strict';
import { test } from 'node:test';
import { tar } from '../ui/tar';
import { componentsOf, parameterLines, programIn, sameValue, tomlOf } from './components';
import { Draft, keyOf } from './draft';
import { flowEdges } from './flow';
import { columnsOf, layoutGraph } from './layout';
import { merge } from './lines';
import { pastChanges } from './past';
import { isSeveral, paste } from './paste';
import { cutComponent, lineEnd, pasteComponent, retype, shown } from './text';

// --- texts

test('typing changes nothing but what is typed, line ends included', () => {
  const text = '# one\r\na = 1\r\n# two\nb = 2\r\n';
  assert.equal(retype(text, shown(text)), text);
  assert.equal(retype(text, '# one\na = 15\n# two\nb = 2\n'), '# one\r\na = 15\r\n# two\nb = 2\r\n');
  assert.equal(retype(text, '# one\na = 1\nc = 3\n# two\nb = 2\n'), '# one\r\na = 1\r\nc = 3\r\n# two\nb = 2\r\n');
  assert.equal(retype(text, '# one\n# two\nb = 2\n'), '# one\r\n# two\nb = 2\r\n');
  assert.equal(retype(text, ''), '');
  assert.equal(retype('', 'a = 1\n'), 'a = 1\n');
  assert.equal(lineEnd(text), '\r\n');
});

const robot = `# A robot.
name = "scout"

# --- drivers

# Brakes hard.
[[component]]
program = "ChassisSim"   # the simulation
parameters = { vxMax = 900 }

[[component]]
program = "LadarSim"

[component.parameters]
text = """
[[component]]
not one"""

# --- the others

# Looks far.
[[component]]
program = "Scan2d"
`;
const places = {
  name: [2, 8],
  'component[0].program': [8, 11],
  'component[0].parameters.vxMax': [9, 24],
  'component[1].program': [12, 11],
  'component[1].parameters.text': [15, 8],
  'component[2].program': [23, 11],
} satisfies Record<string, [number, number]>;

test('a component is cut with its comments, and nothing else', () => {
  const first = cutComponent(robot, places, 0);
  assert.equal(
    first?.block,
    '# Brakes hard.\n[[component]]\nprogram = "ChassisSim"   # the simulation\nparameters = { vxMax = 900 }\n\n',
  );
  assert.equal(first.rest, robot.replace(first.block, ''));
  const second = cutComponent(robot, places, 1);
  assert.ok(second?.block.startsWith('[[component]]\nprogram = "LadarSim"'));
  assert.ok(second?.block.includes('not one"""'));
  assert.ok(!second?.block.includes('Looks far'));
  const last = cutComponent(robot, places, 2);
  assert.equal(last?.block, '# Looks far.\n[[component]]\nprogram = "Scan2d"\n');
  assert.equal(cutComponent(robot, places, 3), undefined);
});

test('a component is pasted behind all others, with the line ends of the file', () => {
  const block = '# Looks far.\n[[component]]\nprogram = "Scan2d"\n\n';
  assert.equal(pasteComponent('name = "a"\n\n\n', block), `name = "a"\n\n${block.trimEnd()}\n`);
  assert.equal(
    pasteComponent('name = "a"\r\n', block),
    'name = "a"\r\n\r\n# Looks far.\r\n[[component]]\r\nprogram = "Scan2d"\r\n',
  );
  assert.equal(pasteComponent('', block), `${block.trimEnd()}\n`);
});

// --- merging

test('changes of different lines are merged', () => {
  const base = 'a\nb\nc\nd\n';
  assert.deepEqual(merge(base, 'a\nB\nc\nd\n', 'a\nb\nc\nD\n'), { text: 'a\nB\nc\nD\n', clashes: [] });
  assert.deepEqual(merge(base, 'a\nb\nc\nd\ne\n', 'x\na\nb\nc\nd\n'), { text: 'x\na\nb\nc\nd\ne\n', clashes: [] });
  assert.deepEqual(merge(base, 'a\nc\nd\n', base), { text: 'a\nc\nd\n', clashes: [] });
  assert.deepEqual(merge(base, base, base), { text: base, clashes: [] });
});

test('of a line that both have changed ours is kept, and told', () => {
  const base = 'a\nb\nc\n';
  assert.deepEqual(merge(base, 'a\nours\nc\n', 'a\ntheirs\nc\n'), {
    text: 'a\nours\nc\n',
    clashes: [{ line: 2, ours: 'ours\n', theirs: 'theirs\n' }],
  });
  assert.deepEqual(merge(base, 'a\nsame\nc\n', 'a\nsame\nc\n'), { text: 'a\nsame\nc\n', clashes: [] });
  assert.equal(merge(base, 'a\nours\n', 'a\nb\ntheirs\n').clashes.length, 1);
});

test('merged lines come from one of the three texts, whatever was changed', () => {
  let seed = 7;
  const random = (below: number) => {
    seed = (seed * 1103515245 + 12345) % 2147483648;
    return seed % below;
  };
  const edit = (lines: string[]) =>
    lines.flatMap((line) => [[line], [], [`${line}'`], [line, `new${random(9)}`], [line], [line]][random(6)]!);
  for (let i = 0; i < 2000; ++i) {
    const base = Array.from({ length: random(8) }, (_, line) => `${line}`);
    const text = (lines: string[]) => lines.map((line) => `${line}\n`).join('');
    const [ours, theirs] = [text(edit(base)), text(edit(base))];
    assert.equal(merge(text(base), ours, text(base)).text, ours);
    assert.equal(merge(text(base), text(base), theirs).text, theirs);
    const known = new Set([...ours.split('\n'), ...theirs.split('\n')]);
    for (const line of merge(text(base), ours, theirs).text.split('\n')) assert.ok(known.has(line), line);
  }
});

// --- the draft

const key = keyOf('robot1', 'robots/scout.toml');

function draftWith(text: string): Draft {
  const draft = new Draft();
  draft.deploy(key, { text, hash: text });
  return draft;
}

test('undo and redo go through the changes; without one the file is not dirty', () => {
  const draft = draftWith('a');
  draft.change('first', [[key, 'b']]);
  draft.change('second', [[key, 'c']]);
  assert.deepEqual([draft.text(key), draft.undoLabel, draft.changed], ['c', 'second', [key]]);
  draft.undo();
  assert.deepEqual([draft.text(key), draft.undoLabel, draft.redoLabel], ['b', 'first', 'second']);
  draft.undo();
  assert.deepEqual([draft.text(key), draft.undoLabel, draft.changed], ['a', undefined, []]);
  draft.undo();
  draft.redo();
  draft.redo();
  draft.redo();
  assert.equal(draft.text(key), 'c');
  draft.change('back', [[key, 'a']]);
  assert.deepEqual(draft.changed, []);
  draft.undo();
  assert.equal(draft.text(key), 'c');
});

test('typing in a file is one step', () => {
  const draft = draftWith('a');
  draft.change('Edit', [[key, 'ab']], true);
  draft.change('Edit', [[key, 'abc']], true);
  draft.change('other', [[key, 'abcd']]);
  draft.change('Edit', [[key, 'abcde']], true);
  draft.undo();
  draft.undo();
  assert.equal(draft.text(key), 'abc');
  draft.undo();
  assert.equal(draft.text(key), 'a');
});

test('an edit has the hash of the text that was edited', () => {
  const draft = draftWith('a');
  const other = keyOf('robot1', 'robots/new.toml');
  draft.change('edit', [
    [key, 'b'],
    [other, 'n'],
  ]);
  assert.deepEqual(draft.edits('robot1'), [
    { file: 'robots/new.toml', base: null, text: 'n' },
    { file: 'robots/scout.toml', base: 'a', text: 'b' },
  ]);
  assert.deepEqual(draft.edits('arm'), []);
  draft.change('remove', [[key, null]]);
  assert.deepEqual(draft.edits('robot1')[1], { file: 'robots/scout.toml', base: 'a', remove: true });
  assert.deepEqual(draft.keys, [other]);
});

test('a change of another editor is a conflict, until it is merged, reloaded or overruled', () => {
  const conflicting = () => {
    const draft = draftWith('a\nb\nc\n');
    draft.change('ours', [[key, 'A\nb\nc\n']]);
    draft.deploy(key, { text: 'a\nb\nC\n', hash: 'theirs' });
    return draft;
  };
  const merging = conflicting();
  assert.deepEqual(merging.conflicts, [key]);
  assert.equal(merging.edits('robot1')[0]?.base, 'a\nb\nc\n');
  assert.deepEqual(merging.merge(key)?.clashes, []);
  assert.equal(merging.text(key), 'A\nb\nC\n');
  assert.equal(merging.edits('robot1')[0]?.base, 'theirs');
  assert.deepEqual([merging.conflicts, merging.undoLabel], [[], undefined]);

  const reloading = conflicting();
  reloading.reload(key);
  assert.deepEqual([reloading.text(key), reloading.changed, reloading.conflicts], ['a\nb\nC\n', [], []]);

  const keeping = conflicting();
  keeping.keep(key);
  assert.deepEqual([keeping.text(key), keeping.conflicts], ['A\nb\nc\n', []]);
});

test('what is deployed as it is in the draft is no change any more', () => {
  const draft = draftWith('a');
  draft.change('edit', [[key, 'b']]);
  draft.deploy(key, { text: 'b', hash: 'b' });
  assert.deepEqual([draft.changed, draft.conflicts, draft.text(key)], [[], [], 'b']);
  draft.change('remove', [[key, null]]);
  draft.deploy(key, null);
  assert.deepEqual([draft.changed, draft.keys], [[], []]);
});

test('a draft survives a reload of the page', () => {
  const draft = draftWith('a');
  draft.change('edit', [[key, 'b']]);
  const other = new Draft();
  other.restore(JSON.parse(JSON.stringify(draft.save())));
  assert.deepEqual(other.conflicts, [key], 'until the host was asked');
  other.deploy(key, { text: 'a', hash: 'a' });
  assert.deepEqual([other.text(key), other.conflicts, other.changed], ['b', [], [key]]);
});

// --- components

const values = {
  name: 'scout',
  system: 3,
  component: [
    { program: 'ChassisSim', parameters: { vxMax: 900, strange: true } },
    { program: 'Scan2d', instance: 1, host: 'arm' },
    { command: "nice -n -15 World --system={system} --file='a b'" },
  ],
};

test('components are read from a robot file', () => {
  const list = componentsOf(key, values);
  assert.deepEqual(
    list.map(({ title, system, instance, on, path }) => [title, system, instance, on, path]),
    [
      ['ChassisSim', 3, 0, '', 'component[0]'],
      ['Scan2d/1', 3, 1, 'arm', 'component[1]'],
      ['World', 3, 0, '', 'component[2]'],
    ],
  );
  assert.deepEqual(componentsOf(key, { component: 'none' }), []);
  assert.deepEqual(componentsOf(key, null), []);
  assert.equal(programIn(''), 'command');
});

test('parameters have their values of the file and their defaults', () => {
  const [component] = componentsOf(key, values);
  const info = { name: 'vxMax', type: 'int' as const, default: 500, help: '' };
  const other = { name: 'vxMin', type: 'int' as const, default: 0, help: '' };
  const program = { program: '', purpose: '', class: 'Chassis', class_id: 16, parameters: [info, other] };
  const lines = parameterLines(component!, program);
  assert.deepEqual(
    lines.map(({ info: { name }, file, usual }) => [name, file, usual]),
    [
      ['strange', 'true', ''],
      ['vxMax', '900', '500'],
      ['vxMin', undefined, '0'],
    ],
  );
});

test('typed values become TOML', () => {
  assert.deepEqual(
    [tomlOf('5', 'int'), tomlOf('0,5', 'float'), tomlOf('{system}', 'int'), tomlOf('5', 'text'), tomlOf('', 'int')],
    [5, 0.5, '{system}', '5', ''],
  );
  assert.ok(sameValue('13', '13.0'));
  assert.ok(!sameValue('', '0'));
});

// --- a spread sheet

test('cells fill the rows below, and rows by their names', () => {
  const names = ['a', 'b', 'a', 'c'];
  assert.deepEqual(paste('1\r\n2\r\n', names, 1).values, [
    { row: 1, value: '1' },
    { row: 2, value: '2' },
  ]);
  assert.deepEqual(paste('a\t7\nx\t8', names, 1), { values: [{ row: 2, value: '7' }], unknown: ['x'] });
  assert.deepEqual(paste('1\n2', names, 3), { values: [{ row: 3, value: '1' }], unknown: ['2'] });
  assert.ok(isSeveral('1\n2'));
  assert.ok(!isSeveral('1\n'));
});

// --- the archive

test('the archive is one that tar reads', async () => {
  const { execFileSync } = await import('node:child_process');
  const archive = tar(
    [
      { path: 'arm/router.toml', content: 'x = 1\n' },
      { path: 'arm/robots/ü.toml', content: 'é'.repeat(600) },
      { path: 'empty.toml', content: new Uint8Array() },
    ],
    1_700_000_000,
  );
  const list = execFileSync('tar', ['-tf', '-'], { input: archive }).toString();
  assert.match(list, /^arm\/router.toml\n/);
  assert.equal(execFileSync('tar', ['-xOf', '-', 'arm/router.toml'], { input: archive }).toString(), 'x = 1\n');
  assert.equal(archive.length % 512, 0);
});

// --- the graph

test('components stand right of those whose data they use', () => {
  const edges = [
    { from: 'ladar', to: 'scan' },
    { from: 'scan', to: 'pilot' },
    { from: 'chassis', to: 'pilot' },
  ];
  assert.deepEqual(columnsOf(['pilot', 'ladar', 'alone', 'chassis', 'scan'], edges, 9), [
    ['ladar', 'chassis', 'alone'],
    ['scan'],
    ['pilot'],
  ]);
  assert.equal(columnsOf(['pilot', 'ladar', 'scan', 'chassis'], edges, 2).length, 2);
  const loop = [
    { from: 'a', to: 'b' },
    { from: 'b', to: 'a' },
    { from: 'a', to: 'a' },
  ];
  assert.equal(columnsOf(['a', 'b'], loop, 9).flat().length, 2);
  assert.deepEqual(columnsOf([], [], 3), [[]]);
});

test('no two boxes of the graph overlap, at any width', () => {
  const hosts = ['base', 'one', 'two'].map((name, i) => ({
    name,
    level: i === 0 ? 0 : 1,
    nodes: Array.from({ length: 4 * i }, (_, node) => `${name}${node}`),
  }));
  const edges = hosts.flatMap(({ nodes }) => nodes.slice(1).map((to, i) => ({ from: nodes[i]!, to })));
  for (const width of [190, 358, 900, 1400]) {
    const layout = layoutGraph(hosts, edges, width);
    for (const boxes of [[...layout.hosts.values()], [...layout.nodes.values()]])
      for (const [i, a] of boxes.entries())
        for (const b of boxes.slice(i + 1))
          assert.ok(
            a.x + a.width <= b.x || b.x + b.width <= a.x || a.y + a.height <= b.y || b.y + b.height <= a.y,
            `${width}`,
          );
    for (const box of layout.hosts.values()) assert.ok(box.y + box.height <= layout.height);
  }
});

test('lines are of what the files want, what flows, and what differs', () => {
  const wanted = [
    { from: 'Scan2d(1/0)', to: 'Ladar(1/0)', parameter: 'ladarSys', to_host: 'a' },
    { from: 'Pilot(1/0)', to: 'Scan2d(1/0)', parameter: 'scan2dSys', to_host: 'a' },
    { from: 'Pilot(1/0)', to: 'Path(1/0)', parameter: 'pathSys', to_host: null },
  ].map((edge) => ({ ...edge, host: 'a', period_ms: 10, bytes_max: 10 }));
  const byName = new Map([
    ['Scan2d(1/0)', 'scan'],
    ['Ladar(1/0)', 'ladar'],
    ['Pilot(1/0)', 'pilot'],
  ]);
  const byAddress = new Map([
    [1, 'scan'],
    [2, 'ladar'],
    [3, 'pilot'],
  ]);
  const listeners = new Map([[2, new Set([1, 3, 99])]]);
  assert.deepEqual(
    flowEdges(wanted, byName, listeners, byAddress).map(({ from, to, kind, missing }) => [from, to, kind, missing]),
    [
      ['ladar', 'scan', 'live', false],
      ['scan', 'pilot', 'planned', false],
      ['Path(1/0)', 'pilot', 'extra', true],
      ['ladar', 'pilot', 'extra', false],
    ],
  );
  assert.deepEqual(
    flowEdges(undefined, byName, listeners, byAddress).map(({ kind }) => kind),
    ['live', 'live'],
  );
});

// --- history

test('a change on several hosts is one of the history, the newest first', () => {
  const item = (generation: number, change: string, time: string, hash: string) => ({
    generation,
    change,
    time,
    who: 'ada',
    why: change,
    outcome: 'confirmed' as const,
    files: [
      { file: 'router.toml', hash: 'same' },
      { file: 'robots/scout.toml', hash },
    ],
  });
  const changes = pastChanges([
    { host: 'a', items: [item(3, 'third', '12:03', 'c'), item(2, 'second', '12:02', 'b'), item(1, '', '12:09', 'a')] },
    { host: 'b', items: [item(7, 'second', '12:02', 'z')] },
  ]);
  assert.deepEqual(
    changes.map(({ change, at }) => [
      change,
      at.map(({ host, generation, files }) => [host, generation, files.length]),
    ]),
    [
      ['third', [['a', 3, 1]]],
      [
        'second',
        [
          ['a', 2, 1],
          ['b', 7, 2],
        ],
      ],
      ['', [['a', 1, 2]]],
    ],
  );
});
