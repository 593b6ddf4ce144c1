// Numbers as operators type them: with a point or a comma.

// Undefined: it is no finite number.
export function numberIn(text: string): number | undefined {
  const number = Number(text.replace(',', '.'));
  return text.trim() !== '' && Number.isFinite(number) ? number : undefined;
}
