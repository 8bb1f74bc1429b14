/** The comment of a node in its file, or that of the task at its top, which drawings and runs don't show. */
import { type JSX, useEffect, useState } from "react";

import { server } from "../../protocol/client";
import { useDocument } from "../../store/document";
import { edit } from "../../store/editing";
import { ValueField } from "./fields";

/** After an edit the server has better things to do at first [ms]. */
const LATER = 250;

export function CommentForm({ path }: { path: string }): JSX.Element {
  const task = useDocument((s) => s.document?.path);
  const revision = useDocument((s) => s.document?.revision);
  const draft = useDocument((s) => s.document?.draft ?? true);
  const [known, setKnown] = useState<string | null>(null);
  useEffect(() => {
    if (task === undefined || revision === undefined) return;
    let late = false;
    const find = (): void =>
      void server.comment(task, path).then(
        (found) => late || setKnown(found.comment),
        // The next revision asks again.
        () => undefined,
      );
    const timer = setTimeout(find, known === null ? 0 : LATER);
    return () => {
      late = true;
      clearTimeout(timer);
    };
    // Not again when it has come: `known` only says how soon.
  }, [task, revision, path]);
  return (
    <ValueField
      label={path === "" ? "Comment at the top of the file" : "Comment in the file"}
      value={known || undefined}
      type="text"
      lines={path === "" ? 3 : 2}
      doc="For whoever edits the file; drawings and runs show the documentation."
      disabled={draft || known === null}
      set={(text) => void edit({ do: "comment", path, text: String(text ?? "") })}
    />
  );
}
