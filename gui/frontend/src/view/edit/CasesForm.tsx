/** The cases of a switch, a row each: the literals, and the child that is taken for them. */
import { type JSX, useEffect, useState } from "react";

import { nameOf } from "../../model/commands";
import { literalsText, parseLiterals, shifted } from "../../model/rows";
import type { NodeView } from "../../protocol/generated";
import { askChoice } from "../../store/ask";
import { edit, settingNow } from "../../store/editing";
import { Field } from "./fields";
import { RowTools } from "./RowTools";

export function CasesForm({ node, locked }: { node: NodeView; locked: boolean }): JSX.Element {
  const entries = (value: unknown): [string, unknown][] => Object.entries((value ?? {}) as Record<string, unknown>);
  const cases = entries(node.fields["cases"]);
  const shift = (at: number, by: -1 | 1): void =>
    void edit(() => ({ do: "set", path: node.path, key: ["cases"], value: Object.fromEntries(shifted(entries(settingNow(node.path, "cases")), at, by)) }));
  const without = node.children.map(nameOf).filter((name) => !cases.some(([child]) => child === name));
  return (
    <section className="rows" aria-label="Cases">
      <h3>Cases</h3>
      {cases.map(([child, said], at) => (
        <div key={child} className="field-row">
          <CaseField child={child} said={said} locked={locked} set={(value) => void edit({ do: "set", path: node.path, key: ["cases", child], value })} />
          {!locked && (
            <RowTools
              about={`the case of ${child}`}
              first={at === 0}
              last={at === cases.length - 1}
              shift={(by) => shift(at, by)}
              remove={() => void edit({ do: "unset", path: node.path, key: ["cases", child] })}
            />
          )}
        </div>
      ))}
      {!locked && without.length > 0 && (
        <button onClick={() => void newCase(node, without)}>New case</button>
      )}
    </section>
  );
}

async function newCase(node: NodeView, without: readonly string[]): Promise<void> {
  const child = without.length === 1 ? without[0] : await askChoice({ title: "New case", label: "Which child is taken?", options: without.map((name) => ({ value: name, label: name })) });
  // The name of the child is a literal that no other case has.
  if (child) await edit({ do: "set", path: node.path, key: ["cases", child], value: child });
}

interface CaseProps {
  readonly child: string;
  readonly said: unknown;
  readonly locked: boolean;
  readonly set: (value: unknown) => void;
}

function CaseField({ child, said, locked, set }: CaseProps): JSX.Element {
  const given = literalsText(said);
  const [text, setText] = useState(given);
  const [fault, setFault] = useState("");
  useEffect(() => {
    setText(given);
    setFault("");
  }, [given]);
  const commit = (): void => {
    if (text === given) return;
    const parsed = parseLiterals(text);
    if ("fault" in parsed) setFault(parsed.fault);
    else set(parsed.value);
  };
  return (
    <Field label={`${child} is taken for`} fault={fault}>
      {(id, about) => (
        <input
          id={id}
          type="text"
          value={text}
          disabled={locked}
          aria-describedby={about}
          aria-invalid={fault !== ""}
          onChange={(event) => setText(event.target.value)}
          onBlur={commit}
          onKeyDown={(event) => {
            if (event.key === "Enter") commit();
            if (event.key === "Escape") setText(given);
          }}
        />
      )}
    </Field>
  );
}
