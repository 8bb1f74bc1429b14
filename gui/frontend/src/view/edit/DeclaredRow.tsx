/** One variable or port with its type and initial value as fields. */
import type { JSX } from "react";

import { variableKey } from "../../model/status";
import type { VariableView } from "../../protocol/generated";
import { redeclare, removeDeclared, renameVariable } from "../../store/declaring";
import { usePage } from "../../store/page";
import { ValueField } from "./fields";

export function DeclaredRow({ variable, locked }: { variable: VariableView; locked: boolean }): JSX.Element {
  const { scope, name, type, initial, whole, ports } = variable;
  const key = variableKey(scope, name);
  const lit = usePage((s) => s.lens === key);
  const output = ports.length === 1 && ports[0] === "output";
  return (
    <li className="declared">
      <span className="form-name">
        {name} {ports.length === 2 && <code>goes in and comes out</code>}
      </span>
      <span className="form-buttons">
        <button className="link" aria-pressed={lit} onClick={() => usePage.getState().setLens(lit ? null : key)}>
          Uses
        </button>
        {!locked && (
          <>
            <button className="link" onClick={() => void renameVariable(variable)}>
              Rename
            </button>
            <button className="link" aria-label={`Remove ${name}`} onClick={() => void removeDeclared(variable)}>
              Remove
            </button>
          </>
        )}
      </span>
      <div className="pair">
        <ValueField label={`Type of ${name}`} type="text" value={type} disabled={locked} set={(next) => void redeclare(variable, { type: String(next ?? "Any") })} />
        {(!output || initial !== null) && (
          <ValueField
            label={`Value of ${name}`}
            type={type}
            value={initial === null ? undefined : whole ? (JSON.parse(initial) as unknown) : initial}
            placeholder="none at first"
            disabled={locked || !whole}
            {...(whole ? {} : { doc: "Too long for a field: change it in the text." })}
            set={(next) => void redeclare(variable, { value: next })}
          />
        )}
      </div>
    </li>
  );
}
