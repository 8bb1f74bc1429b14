/** What the person has to decide: somebody else was faster, or has changed the file. Nothing is lost either way. */
import type { JSX } from "react";

import { useDocument } from "../../store/document";
import { save, takeFromDisk, typeText, undo } from "../../store/editing";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";

export function Conflicts(): JSX.Element {
  const conflict = useDocument((s) => s.conflict);
  const document = useDocument((s) => s.document);
  const record = useRun((s) => s.record);
  const { setConflict } = useDocument.getState();
  const changed = record === null && document !== null && document.change !== "" && conflict?.kind !== "disk";
  return (
    <>
      {conflict && (
        <div className="notice bad" role="alert">
          <p>{conflict.message}</p>
          <span className="buttons">
            {conflict.kind === "disk" && <DiskButtons />}
            {conflict.kind === "stale" && conflict.text !== undefined && (
              <>
                <button onClick={() => void typeText(conflict.text as string, null)}>Put my text over it</button>
                <button onClick={() => useDocument.getState().resetText()}>Take the new text</button>
              </>
            )}
            {conflict.kind === "unfinished" && (
              <>
                <button onClick={() => usePage.getState().setView("text")}>Show the text</button>
                <button onClick={() => void undo()}>Drop it</button>
              </>
            )}
            <button onClick={() => setConflict(null)}>Close</button>
          </span>
        </div>
      )}
      {changed && (
        <div className="notice" role="status">
          <p>The file was {document.change} outside the editor.</p>
          <span className="buttons">
            <DiskButtons />
          </span>
        </div>
      )}
    </>
  );
}

function DiskButtons(): JSX.Element {
  const change = useDocument((s) => s.document?.change);
  return (
    <>
      {change === "changed" && <button onClick={() => void takeFromDisk()}>Take the file's text</button>}
      <button onClick={() => void save(true)}>Save mine over it</button>
    </>
  );
}
