/** Buttons at the end of a row of a form: up, down, remove. */
import type { JSX } from "react";

interface Props {
  readonly about: string;
  readonly first: boolean;
  readonly last: boolean;
  readonly shift: (by: -1 | 1) => void;
  readonly remove: () => void;
}

export function RowTools({ about, first, last, shift, remove }: Props): JSX.Element {
  return (
    <span className="row-tools">
      <button aria-label={`Move ${about} up`} title="Up" disabled={first} onClick={() => shift(-1)}>
        ↑
      </button>
      <button aria-label={`Move ${about} down`} title="Down" disabled={last} onClick={() => shift(1)}>
        ↓
      </button>
      <button aria-label={`Remove ${about}`} title="Remove" onClick={remove}>
        ×
      </button>
    </span>
  );
}
