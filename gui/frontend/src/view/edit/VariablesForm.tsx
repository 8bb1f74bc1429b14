/** Variables that a container, or the task, declares: name, type and initial value. */
import type { JSX } from "react";

import { newVariable } from "../../store/gestures";
import { useRun } from "../../store/run";
import { DeclaredRow } from "./DeclaredRow";

export function VariablesForm({ scope, locked }: { scope: string; locked: boolean }): JSX.Element {
  const variables = useRun((s) => s.task.variables);
  const here = variables.filter((variable) => variable.scope === scope && variable.ports.length === 0);
  const about = scope === "" ? "the task" : "this container";
  return (
    <>
      <h3>Variables of {about}</h3>
      {here.length > 0 && (
        <ul className="form-list">
          {here.map((variable) => (
            <DeclaredRow key={variable.name} variable={variable} locked={locked} />
          ))}
        </ul>
      )}
      {!locked && <button onClick={() => void newVariable(scope)}>New variable</button>}
    </>
  );
}
