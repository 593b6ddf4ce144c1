import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Steps } from './steps';

test('the last step is taken back first; one that cannot be does not stand before the others', async () => {
  const steps = new Steps();
  assert.equal(await steps.undo(), '');
  steps.add({ title: 'first', undo: async () => 'back' });
  steps.add({
    title: 'second',
    undo: async () => {
      throw new Error('it is gone');
    },
  });
  assert.equal(steps.last.value?.title, 'second');
  await assert.rejects(steps.undo(), /it is gone/);
  assert.equal(steps.last.value?.title, 'first');
  assert.equal(await steps.undo(), 'back');
  assert.equal(steps.last.value, undefined);
});
