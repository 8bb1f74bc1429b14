/** Where in the task the flow chart is; each container above can be gone to. */
import type { JSX } from "react";

import { parentOf } from "../../model/commands";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";
import { NewPane } from "../NewPane";

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
      <NewPane task={file} at={container} words="Open this container in a pane of its own" />
    </nav>
  );
}
