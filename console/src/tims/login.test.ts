import assert from 'node:assert/strict';
import { afterEach, test } from 'node:test';
import { hindrance, login, may, tokenOf } from './login';

afterEach(() => {
  login.value = { user: '', right: 'configure' };
});

test('a right includes the lower ones', () => {
  login.value = { user: 'anna', right: 'drive' };
  assert.ok(may('look') && may('drive'));
  assert.ok(!may('configure'));
  assert.equal(hindrance('drive'), '');
  assert.match(hindrance('configure'), /may only drive: this needs the right to configure/);
});

test('a token is read from its link only', () => {
  const token = '0123456789abcdef0123456789abcdef';
  assert.equal(tokenOf(`#/login/${token}`), token);
  for (const other of ['', '#/fleet', '#/login/', `#/login/${token}0`, `#/login/${token.toUpperCase()}`])
    assert.equal(tokenOf(other), undefined);
});
