import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Level } from '../tims/gdos';
import { firstErrors } from './first_errors';

const text = (sender: number, level: Level, words: string) => ({ sender, level, text: words });

test('after an error a component is quiet until it begins anew; others are heard', () => {
  const texts = [
    text(1, 'info', 'before'),
    text(1, 'error', 'cannot open /dev/video0'),
    text(1, 'error', 'cannot open /dev/video0 again'),
    text(2, 'warning', 'of another one'),
    text(1, 'warning', 'still'),
    text(1, 'print', 'Module off'),
    text(1, 'info', 'after'),
    text(1, 'error', 'a new one'),
    text(1, 'detail', 'and what follows'),
    text(1, 'print', 'Module on'),
  ];
  const { shown, hidden } = firstErrors(texts);
  assert.deepEqual(
    shown.map((each) => each.text),
    ['before', 'cannot open /dev/video0', 'of another one', 'Module off', 'after', 'a new one', 'Module on'],
  );
  assert.equal(hidden, 3);
});

test('an error that begins with what it could not do anew hides what follows', () => {
  assert.equal(firstErrors([text(1, 'error', 'terminated by signal 11'), text(1, 'info', 'x')]).hidden, 1);
});

test('nothing is hidden without an error', () => {
  assert.equal(firstErrors([text(1, 'warning', 'a'), text(1, 'print', 'b')]).hidden, 0);
});
