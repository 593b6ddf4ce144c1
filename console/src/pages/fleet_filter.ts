// Which robots the filter of the fleet leaves. Pure.

export interface Named {
  system: number;
  name: string | null | undefined; // of its router
  words: string[]; // of its state: "error", "no answer", "away"
}

// All words, in any order, each in the number, in the name, or in the state.
export function matchesRobot({ system, name, words }: Named, filter: string): boolean {
  if (filter === '') return true;
  const text = [system === 0 ? 'base' : `robot ${system}`, name ?? '', ...words].join(' ').toLowerCase();
  return filter
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}
