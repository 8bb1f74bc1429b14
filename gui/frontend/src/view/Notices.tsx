/** What a person must not miss: refused requests, what became of a run and of the robot, errors in nodes. */
import type { JSX } from "react";

import { processNotices } from "../model/words";
import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { Conflicts } from "./edit/Conflicts";

export function Notices(): JSX.Element {
  const trouble = useRun((s) => s.trouble);
  const session = useRun((s) => s.session);
  const error = useRun((s) => s.moment.facts.error);
  return (
    <div className="notices">
      <Conflicts />
      {trouble && (
        <div className="notice bad" role="alert">
          <p>{trouble}</p>
          <button onClick={() => useRun.getState().setTrouble("")}>Close</button>
        </div>
      )}
      {processNotices(session).map(({ text, bad }) => (
        <div key={text} className={`notice${bad ? " bad" : ""}`} role={bad ? "alert" : "status"}>
          <pre>{text}</pre>
        </div>
      ))}
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
    </div>
  );
}
