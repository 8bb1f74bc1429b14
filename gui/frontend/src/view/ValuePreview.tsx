/** A value that a run has written, looked at: its parts, and a drawing of clouds and images. */
import { type JSX, useEffect, useState } from "react";

import { server } from "../protocol/client";
import type { ValueView } from "../protocol/generated";

export function ValuePreview({ run, seq, name }: { run: string; seq: number; name: string }): JSX.Element {
  const [view, setView] = useState<ValueView | null>(null);
  const [trouble, setTrouble] = useState("");
  useEffect(() => {
    let left = false;
    server.value(run, seq).then(
      (found) => left || setView(found),
      (error: unknown) => left || setTrouble(error instanceof Error ? error.message : String(error)),
    );
    return () => {
      left = true;
    };
  }, [run, seq]);
  if (!view) return <p className="hint">{trouble || "Fetching ..."}</p>;
  return (
    <div className="value-preview">
      {view.picture && (
        <figure>
          <img src={view.picture} alt={`${name}: ${view.caption}`} />
          <figcaption>{view.caption}</figcaption>
        </figure>
      )}
      <p>{view.text}</p>
      {view.rows.length > 0 && (
        <dl>
          {view.rows.map(([part, text]) => (
            <div key={part}>
              <dt>{part}</dt>
              <dd>{text}</dd>
            </div>
          ))}
        </dl>
      )}
    </div>
  );
}
