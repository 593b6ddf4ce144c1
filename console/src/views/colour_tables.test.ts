import assert from 'node:assert/strict';
import { test } from 'node:test';
import { colourTable, tableNames } from './colour_tables';

test('a table mixes the colours of its stops', () => {
  const table = colourTable('grey to 255');
  assert(table !== undefined);
  assert.deepEqual(table(0), [0, 0, 0]);
  assert.deepEqual(table(51), [51, 51, 51]);
  assert.deepEqual(table(255), [255, 255, 255]);
  assert.deepEqual(table(0xffff), [255, 0, 0]);
  assert.deepEqual(colourTable('range indoors')?.(1500), [0, 128, 128]);
});

test('every table has a colour for every value, also outside of its range', () => {
  assert.equal(tableNames.length, 10);
  for (const name of tableNames)
    for (const value of [-1, 0, 1, 63, 64, 4095, 4096, 0xfffe, 0xffff, 0x10000])
      for (const part of colourTable(name)?.(value) ?? [Number.NaN])
        assert(part >= 0 && part <= 255, `${name} ${value}`);
});

test('a name that is none has no table', () => assert.equal(colourTable('grey'), undefined));
