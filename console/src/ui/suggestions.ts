// What a box offers of many names. Pure.

export const suggestionsMax = 100; // of thousands a browser shows no more at once

// The first names that contain the text.
export function suggestionsFor(text: string, names: Iterable<string>): string[] {
  const wanted = text.trim().toLowerCase();
  const found: string[] = [];
  for (const name of names) {
    if (found.length === suggestionsMax) break;
    if (name.toLowerCase().includes(wanted)) found.push(name);
  }
  return found;
}
