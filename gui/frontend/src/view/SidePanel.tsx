/** The variables at the shown moment, who writes and reads them (the data lens), and what a value looks like: its parts, a drawing of clouds and images. */
import { type JSX, type ReactNode, useEffect, useRef, useState } from "react";
import { seconds } from "../model/words";
import { variableKey } from "../model/status";
import { usesOf } from "../model/values";
import type { ValueView, VariableView } from "../protocol/generated";
import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { server } from "../protocol/client";
import { askText } from "../store/ask";

export function VariablesPanel(): JSX.Element {
  const variables = useRun((s) => s.task.variables);
  return (
    <section className="panel" aria-labelledby="variables-title">
      <h2 id="variables-title">Variables</h2>
      <div className="scroll" tabIndex={0} role="group" aria-labelledby="variables-title">
        <table>
          <thead>
            <tr>
              <th scope="col">Variable</th>
              <th scope="col">Value</th>
              <th scope="col">Writer</th>
            </tr>
          </thead>
          <tbody>
            {variables.map((variable) => (
              <VariableRow key={variableKey(variable.scope, variable.name)} variable={variable} />
            ))}
          </tbody>
        </table>
        {variables.length === 0 && <p className="hint padded">The task declares no variables.</p>}
      </div>
    </section>
  );
}

function VariableRow({ variable }: { variable: VariableView }): JSX.Element {
  const value = useRun((s) => s.moment.variables.get(variableKey(variable.scope, variable.name)));
  const { select } = usePage.getState();
  const key = variableKey(variable.scope, variable.name);
  const lit = usePage((s) => s.lens === key);
  const index = useRun((s) => s.index);
  const preview = value?.preview ?? plain(variable.initial ?? "");
  const run = useRun((s) => s.record?.id);
  const [open, setOpen] = useState(false);
  return (
    <>
    <tr>
      <th scope="row" title={[variable.doc, `declared at ${variable.scope || "the task"}`].filter(Boolean).join("\n")}>
        <button className="link" aria-pressed={lit} onClick={() => usePage.getState().setLens(lit ? null : key)}>
          {variable.name}
        </button>{" "}
        <code>{value?.type || variable.type}</code>
      </th>
      <td title={preview}>
        {value && run ? (
          <button className="preview link" aria-expanded={open} title={`Look at ${variable.name}`} onClick={() => setOpen(!open)}>
            {preview}
          </button>
        ) : (
          <div className="preview">{preview || <span className="hint">not written</span>}</div>
        )}
      </td>
      <td>
        {value && (
          <button className="link" onClick={() => select(value.writer)} title={`${value.writer} at ${seconds(value.t)}`}>
            {value.writer.split("/").at(-1) || "/"}
          </button>
        )}
        {lit && (
          <ul className="uses">
            {usesOf(index, key).map(({ path, how }) => (
              <li key={path + how}>
                {how}{" "}
                <button className="link" title={path} onClick={() => select(path)}>
                  {path.split("/").at(-1) || "/"}
                </button>
              </li>
            ))}
          </ul>
        )}
      </td>
    </tr>
    {open && value && run && (
      <tr className="preview-row">
        <td colSpan={3}>
          <ValuePreview run={run} seq={value.seq} name={variable.name} />
        </td>
      </tr>
    )}
    </>
  );
}

/** A value of the file without the marks of its notation, as far as it can be read so. */
function plain(text: string): string {
  return text.startsWith("{") ? text.slice(1, -1).replace(/"(\w+)":/g, "$1:") : text;
}

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
