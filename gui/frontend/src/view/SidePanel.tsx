/** The variables at the shown moment, and who writes and reads them: the data lens. */
import { type JSX, useState } from "react";

import { seconds } from "../model/words";
import { variableKey } from "../model/status";
import { usesOf } from "../model/values";
import type { VariableView } from "../protocol/generated";
import { usePage } from "../store/page";
import { isKept, useRun } from "../store/run";
import { ValuePreview } from "./ValuePreview";

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
  const preview = value?.preview ?? variable.initial ?? "";
  const id = useRun((s) => s.record?.id);
  const run = isKept(id) ? id : undefined;
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
