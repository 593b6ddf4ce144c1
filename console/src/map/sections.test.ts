import assert from 'node:assert/strict';
import { test } from 'node:test';
import { sectionsOf } from './sections';
import { readWorldFile } from './world_file';

const place = { north: 50_000, west: -20_000, cell: 100 };
const placeOf = (text: string) => readWorldFile(text, { north: 0, east: 0 });

test('a picture that fits is one section, as it is', () => {
  const [section, ...others] = sectionsOf({ width: 100, height: 60 }, place, 100);
  assert.equal(others.length, 0);
  assert.deepEqual([section?.x, section?.y, section?.width, section?.height, section?.factor], [0, 0, 100, 60, 1]);
  assert.deepEqual(placeOf(section?.worldFile ?? ''), place);
});

test('a larger one is covered by each level, the last is one section', () => {
  const sections = sectionsOf({ width: 250, height: 101 }, place, 100);
  assert.deepEqual(
    sections.map(({ name }) => name),
    ['1-0-0', '1-0-1', '1-0-2', '1-1-0', '1-1-1', '1-1-2', '2-0-0', '2-0-1', '4-0-0'],
  );
  for (const level of [1, 2, 4]) {
    const area = sections.filter(({ factor }) => factor === level).reduce((sum, s) => sum + s.width * s.height, 0);
    assert.equal(area, 250 * 101);
  }
  const corner = sections.find(({ name }) => name === '1-1-2');
  assert.deepEqual(placeOf(corner?.worldFile ?? ''), { north: 40_000, west: 0, cell: 100 });
  assert.deepEqual(placeOf(sections.at(-1)?.worldFile ?? ''), { ...place, cell: 400 });
});
