/** A link that shows a container of a task in a browser window of its own, to be put beside this one. */
import type { JSX } from "react";

export function NewPane({ task, at, words }: { task: string; at: string; words: string }): JSX.Element {
  return (
    <a className="new-pane" href={`/?${new URLSearchParams({ task, at })}`} target="_blank" rel="noopener" title={words}>
      <svg className="icon" viewBox="0 0 16 16" aria-hidden="true">
        <path d="M6 3H2.5v10.5H13V10M9 2.5h4.5V7M13 3 7.5 8.5" />
      </svg>
      <span className="hidden">{words}</span>
    </a>
  );
}
