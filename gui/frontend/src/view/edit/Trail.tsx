/** The tasks through whose subtasks this one was come to; each can be gone back to. */
import type { JSX } from "react";

import { nameOf } from "../../model/commands";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";
import { goUp } from "../../store/subtasks";

export function Trail(): JSX.Element | null {
  const trail = usePage((s) => s.trail);
  const name = useRun((s) => s.task.name);
  if (trail.length === 0) return null;
  return (
    <nav aria-label="Tasks above">
      <ol className="crumbs">
        {trail.map((above, at) => (
          <li key={`${above.task} ${above.node}`}>
            <button className="link" title={`Back to ${above.task}, at ${above.node}`} onClick={() => void goUp(at)}>
              {above.name}/{nameOf(above.node)}
            </button>
          </li>
        ))}
        <li aria-current="page">{name}</li>
      </ol>
    </nav>
  );
}
