/** Variables that a container, or the task, declares: name, type and initial value. */
import type { JSX } from "react";

import { variableKey } from "../../model/status";
import type { VariableView } from "../../protocol/generated";
import { edit } from "../../store/editing";
import { askText } from "../../store/ask";
import { nameCheck, newVariable } from "../../store/gestures";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";

export function VariablesForm({ scope, locked }: { scope: string; locked: boolean }): JSX.Element {
  const variables = useRun((s) => s.task.variables);
  const here = variables.filter((variable) => variable.scope === scope);
  const about = scope === "" ? "the task" : "this container";
  return (
    <>
      <h3>Variables of {about}</h3>
      {here.length > 0 && (
        <ul className="form-list">
          {here.map((variable) => (
            <VariableItem key={variable.name} variable={variable} locked={locked} />
          ))}
        </ul>
      )}
      {!locked && <button onClick={() => void newVariable(scope)}>New variable</button>}
    </>
  );
}

function VariableItem({ variable, locked }: { variable: VariableView; locked: boolean }): JSX.Element {
  const { scope, name, type, initial } = variable;
  const key = variableKey(scope, name);
  const lit = usePage((s) => s.lens === key);
  return (
    <li>
      <span className="form-name">
        {name} <code>{type}</code> {initial !== null && <code>= {initial}</code>}
      </span>
      <span className="form-buttons">
        <button className="link" aria-pressed={lit} onClick={() => usePage.getState().setLens(lit ? null : key)}>
          Uses
        </button>
        {!locked && (
          <>
            <button className="link" onClick={() => void change(variable)}>
              Rename
            </button>
            <button className="link" onClick={() => void edit({ do: "undeclare", path: scope, name })}>
              Remove
            </button>
          </>
        )}
      </span>
    </li>
  );
}

async function change({ scope, name }: VariableView): Promise<void> {
  const taken = useRun.getState().task.variables.filter((each) => each.scope === scope && each.name !== name).map((each) => each.name);
  const to = await askText({ title: `Rename the variable ${name}`, label: "Name", initial: name, check: nameCheck(taken), hint: "Bindings and expressions follow." });
  if (to !== null && to !== name) await edit({ do: "rename_variable", path: scope, name, to });
}
