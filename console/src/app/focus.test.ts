import assert from 'node:assert/strict';
import { test } from 'node:test';
import { isSlider, isText } from './focus';

const element = (tagName: string, type?: string) => ({ tagName, type }) as unknown as EventTarget;

test('texts are typed; sliders, boxes and buttons are not', () => {
  for (const type of ['text', 'search', 'number', 'password', 'date']) assert(isText(element('INPUT', type)), type);
  for (const tag of ['TEXTAREA', 'SELECT', 'select']) assert(isText(element(tag)), tag);
  for (const type of ['range', 'checkbox', 'radio', 'button', 'submit', 'file'])
    assert(!isText(element('INPUT', type)), type);
  assert(isText({ tagName: 'P', isContentEditable: true } as unknown as EventTarget));
  for (const target of [element('BUTTON', 'button'), element('BODY'), {} as EventTarget, null]) assert(!isText(target));
});

test('arrows move sliders and choose among radio buttons', () => {
  assert(isSlider(element('INPUT', 'range')));
  assert(isSlider(element('INPUT', 'radio')));
  for (const target of [element('INPUT', 'text'), element('BUTTON'), {} as EventTarget, null])
    assert(!isSlider(target));
});
