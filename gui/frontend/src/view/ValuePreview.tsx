/** A value that a run has written, looked at: its parts, and a drawing of clouds and images. */
import { type JSX, type ReactNode, useEffect, useRef, useState } from "react";

import { server } from "../protocol/client";
import type { ValueView } from "../protocol/generated";
import { askText } from "../store/ask";

export function ValuePreview({ run, seq, name }: { run: string; seq: number; name: string }): JSX.Element {
  const [view, setView] = useState<ValueView | null>(null);
  const [error, setError] = useState("");
  useEffect(() => {
    let left = false;
    server.value(run, seq).then(
      (found) => left || setView(found),
      (error: unknown) => left || setError(error instanceof Error ? error.message : String(error)),
    );
    return () => {
      left = true;
    };
  }, [run, seq]);
  if (!view) return <p className="hint">{error || "Fetching ..."}</p>;
  return (
    <ValueShown view={view} name={name}>
      {(view.type === "Pose" || view.type === "JointState") && <Keep run={run} seq={seq} name={name} />}
    </ValueShown>
  );
}

/** A value's drawing, its line, and its parts. */
export function ValueShown({ view, name, children }: { view: ValueView; name: string; children?: ReactNode }): JSX.Element {
  const large = useRef<HTMLDialogElement>(null);
  return (
    <div className="value-preview">
      {view.picture && (
        <figure>
          <button className="picture" title="Look at it large" aria-label={`${name}, large`} onClick={() => large.current?.showModal()}>
            <img src={view.picture} alt={`${name}: ${view.caption}`} />
          </button>
          <dialog ref={large} className="large" aria-label={name} onClick={() => large.current?.close()}>
            <img src={view.picture} alt={`${name}, large: ${view.caption}`} />
            <p>
              {name}: {view.caption} <button autoFocus>Close</button>
            </p>
          </dialog>
          <figcaption>{view.caption}</figcaption>
        </figure>
      )}
      <p>{view.text}</p>
      {children}
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

/** What was measured becomes a named message of the project. */
function Keep({ run, seq, name }: { run: string; seq: number; name: string }): JSX.Element {
  const [said, setSaid] = useState("");
  async function keep(): Promise<void> {
    const chosen = await askText({ title: "Keep by name", label: "Name", initial: name, hint: "It becomes an entry of the project's named messages" });
    if (chosen === null) return;
    try {
      setSaid(`kept in ${(await server.record({ run, seq, name: chosen })).path}`);
    } catch (error) {
      setSaid(error instanceof Error ? error.message : String(error));
    }
  }
  return (
    <p>
      <button onClick={() => void keep()}>Keep by name</button> <output>{said}</output>
    </p>
  );
}
