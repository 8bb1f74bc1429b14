/** Everything that was done, with its branches: any moment can be gone back to. */
import type { JSX } from "react";

import { historyRows } from "../../model/moments";
import { useDocument } from "../../store/document";
import { goTo } from "../../store/editing";

export function HistoryPanel(): JSX.Element {
  const history = useDocument((s) => s.document?.history);
  const rows = history ? historyRows(history) : [];
  return (
    <section className="panel moments" aria-labelledby="moments-title">
      <h2 id="moments-title">History</h2>
      <ol className="scroll" tabIndex={0} aria-labelledby="moments-title">
        {rows.map((row) => (
          <li key={row.number} style={{ paddingInlineStart: `${8 + row.branch * 18}px` }}>
            <button className="link" {...(row.current ? { "aria-current": "step" as const } : {})} onClick={() => void goTo(row.number)}>
              {row.title}
            </button>
            {row.branch > 0 && row.starts && <span className="hint"> (branch)</span>}
            {row.current && <span className="hint"> (now)</span>}
          </li>
        ))}
      </ol>
    </section>
  );
}
