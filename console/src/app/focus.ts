// Which keys what has the focus takes for itself.

const moved = ['range', 'radio']; // by arrows
const notTyped = [...moved, 'checkbox', 'button', 'submit', 'reset', 'image', 'color', 'file'];

// All that is typed.
export function isText(target: EventTarget | null): boolean {
  const { tagName = '', type = '', isContentEditable = false } = (target ?? {}) as Partial<HTMLInputElement>;
  if (/^input$/i.test(tagName)) return !notTyped.includes(type);
  return isContentEditable || /^(textarea|select)$/i.test(tagName);
}

// Arrows, and the keys beside them.
export function isSlider(target: EventTarget | null): boolean {
  const { tagName = '', type = '' } = (target ?? {}) as Partial<HTMLInputElement>;
  return /^input$/i.test(tagName) && moved.includes(type);
}
