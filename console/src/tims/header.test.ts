import assert from 'node:assert/strict';
import { test } from 'node:test';
import { encodeMessage, messagesIn } from './header';

const joined = (...parts: Uint8Array[]) => Uint8Array.from(parts.flatMap((part) => [...part]));
const message = (type: number, size: number) => encodeMessage({ type }, new Uint8Array(size).fill(type));

test('a frame with one message', () => {
  assert.deepEqual(messagesIn(message(1, 5)), [message(1, 5)]);
});

test('a frame with several messages, of all sizes and in both byte orders', () => {
  const bigEndian = Uint8Array.of(0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 17, 42);
  const messages = [message(1, 0), bigEndian, message(2, 5000), message(3, 1)];
  const frame = joined(...messages);
  const found = messagesIn(frame);
  assert.deepEqual(found, messages);
  assert.ok(found.every(({ buffer }) => buffer === frame.buffer));
});

test('what is no message is handed on with its rest', () => {
  for (const rest of [
    new Uint8Array(1),
    message(4, 5).subarray(0, 15),
    message(4, 5).subarray(0, 20), // shorter than its header states
    Uint8Array.of(1, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 15, 0, 0, 0, 9), // states less than a header
  ])
    assert.deepEqual(messagesIn(joined(message(1, 2), rest)), [message(1, 2), rest]);
  assert.deepEqual(messagesIn(new Uint8Array()), [new Uint8Array()]);
});
