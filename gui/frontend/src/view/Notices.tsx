/** What a person must not miss: refused requests, a run that died or was killed, errors in nodes, problems of the task. */
import type { JSX } from "react";

import { usePage } from "../store/page";
import { useRun } from "../store/run";

export function Notices(): JSX.Element {
  const trouble = useRun((s) => s.trouble);
  const session = useRun((s) => s.session);
  const error = useRun((s) => s.moment.facts.error);
  const lost = session?.state === "ended" && (session.status === "killed" || session.status === "died");
  return (
    <div className="notices">
      {trouble && (
        <div className="notice bad" role="alert">
          <p>{trouble}</p>
          <button onClick={() => useRun.getState().setTrouble("")}>Close</button>
        </div>
      )}
      {session && session.message && (lost || session.state === "starting") && (
        <div className={`notice${lost ? " bad" : ""}`} role={lost ? "alert" : "status"}>
          <pre>{session.message}</pre>
        </div>
      )}
      {error && (
        <div className="notice bad" role="alert">
          <details>
            <summary>
              {error.path}: {error.type}: {error.message}
            </summary>
            <pre>{error.traceback}</pre>
          </details>
          <button onClick={() => usePage.getState().select(error.path)}>Show</button>
        </div>
      )}
      <Problems />
    </div>
  );
}

function Problems(): JSX.Element | null {
  const problems = useRun((s) => s.task.problems);
  if (problems.length === 0) return null;
  const errors = problems.filter((problem) => problem.severity === "error").length;
  return (
    <details className={`notice${errors ? " bad" : ""}`} open={errors > 0}>
      <summary>
        Problems: {errors} errors, {problems.length - errors} warnings
      </summary>
      <ul>
        {problems.map((problem, i) => (
          <li key={i}>
            <strong>{problem.severity}</strong> {problem.line !== null && `line ${problem.line}, `}
            {problem.path && `${problem.path}: `}
            {problem.message}
            {problem.fix && ` ${problem.fix}`}
          </li>
        ))}
      </ul>
    </details>
  );
}
