/** Where in the task the flow chart is; each container above can be gone to. */
import type { JSX } from "react";

import { parentOf } from "../../model/commands";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";

export function Breadcrumbs(): JSX.Element {
  const container = usePage((s) => s.container);
  const index = useRun((s) => s.index);
  const file = useRun((s) => s.task.path);
  const name = useRun((s) => s.task.name);
  const { enter, select } = usePage.getState();
  const chain: string[] = [];
  for (let at: string | null = container; at !== null; at = parentOf(at)) chain.unshift(at);
  return (
    <nav aria-label="Containers">
      <ol className="crumbs">
        {chain.map((path) => (
          <li key={path}>
            <button
              className="link"
              {...(path === container ? { "aria-current": "location" as const } : {})}
              onClick={() => {
                enter(path);
                select(path);
              }}
            >
              {path === "/" ? name : index.byPath.get(path)?.name}
            </button>
          </li>
        ))}
      </ol>
      <a className="new-pane" href={`/?${new URLSearchParams({ task: file, at: container })}`} target="_blank" rel="noopener" title="Open this container in a pane of its own">
        <svg className="icon" viewBox="0 0 16 16" aria-hidden="true">
          <path d="M6 3H2.5v10.5H13V10M9 2.5h4.5V7M13 3 7.5 8.5" />
        </svg>
        <span className="hidden">Open this container in a pane of its own</span>
      </a>
    </nav>
  );
}
