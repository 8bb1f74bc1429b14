/** What a person must not miss: refused requests, a run that died or was killed, errors in nodes. */
import type { JSX } from "react";

import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { Conflicts } from "./edit/Conflicts";

export function Notices(): JSX.Element {
  const trouble = useRun((s) => s.trouble);
  const session = useRun((s) => s.session);
  const error = useRun((s) => s.moment.facts.error);
  const lost = session?.state === "ended" && (session.status === "killed" || session.status === "died");
  return (
    <div className="notices">
      <Conflicts />
      {trouble && (
        <div className="notice bad" role="alert">
          <p>{trouble}</p>
          <button onClick={() => useRun.getState().setTrouble("")}>Close</button>
        </div>
      )}
      {session && session.message && (lost || session.state !== "ended") && (
        <div className={`notice${lost ? " bad" : ""}`} role={lost ? "alert" : "status"}>
          <pre>{session.message}</pre>
        </div>
      )}
      {session !== null && session.zombies.length > 0 && (
        <div className="notice bad" role="alert">
          <p>Left behind at the end, since it hung: {session.zombies.join(", ")}</p>
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
    </div>
  );
}
