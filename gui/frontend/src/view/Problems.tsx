/** What the validation says about the task; errors keep it from running, never from being drawn. */
import type { JSX } from "react";

import { usePage } from "../store/page";
import { useRun } from "../store/run";

export function Problems(): JSX.Element | null {
  const problems = useRun((s) => s.task.problems);
  const known = useRun((s) => s.index.byPath);
  const { select } = usePage.getState();
  if (problems.length === 0) return null;
  const errors = problems.filter((problem) => problem.severity === "error").length;
  return (
    <details className={`panel problems${errors ? " bad" : ""}`} open={errors > 0}>
      <summary>
        Problems: {count(errors, "error")}, {count(problems.length - errors, "warning")}
      </summary>
      <ul className="scroll" tabIndex={0} aria-label="Problems of the task">
        {problems.map((problem, i) => (
          <li key={i}>
            <strong>{problem.severity}</strong>
            {problem.line !== null && `, line ${problem.line}`}
            {known.has(problem.path) && (
              <>
                {", "}
                <button className="link" onClick={() => select(problem.path)}>
                  {problem.path}
                </button>
              </>
            )}
            <br />
            {problem.message}
            {problem.fix && <em> {problem.fix}</em>}
          </li>
        ))}
      </ul>
    </details>
  );
}

function count(n: number, what: string): string {
  return `${n === 0 ? "no" : n} ${what}${n === 1 ? "" : "s"}`;
}
