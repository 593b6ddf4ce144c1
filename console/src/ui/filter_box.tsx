// The box that filters what a page lists; `/` goes to it (app/keys.tsx).

interface Properties {
  label: string;
  placeholder?: string;
  value: string;
  change: (text: string) => void;
}

export function FilterBox({ label, placeholder = 'Filter', value, change }: Properties) {
  return (
    <input
      type="search"
      data-filter
      placeholder={placeholder}
      aria-label={label}
      value={value}
      onInput={(event) => change(event.currentTarget.value)}
    />
  );
}
