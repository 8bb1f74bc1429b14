/** What the task as a whole says: its documentation, how it ends, its variables. */
import { type JSX, useEffect, useState } from "react";

import { variableKey } from "../../model/status";
import { server } from "../../protocol/client";
import type { VariableView } from "../../protocol/generated";
import { askChoice, askText } from "../../store/ask";
import { newPort, redeclare, removeDeclared, renameVariable, type Side } from "../../store/declaring";
import { useDocument } from "../../store/document";
import { edit } from "../../store/editing";
import { nameCheck, newVariable } from "../../store/gestures";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";
import { ValueField } from "./fields";

export function TaskForm({ locked }: { locked: boolean }): JSX.Element {
  const task = useRun((s) => s.task);
  return (
    <>
      <h3>The task</h3>
      <ValueField label="What it is for" value={task.doc || undefined} type="text" lines={2} disabled={locked} set={(value) => void edit(value === undefined ? { do: "unset", path: "", key: ["doc"] } : { do: "set", path: "", key: ["doc"], value })} />
      {!locked && <CommentForm path="" />}
      <ul className="form-list">
        {Object.entries(task.outcomes).map(([name, meaning]) => (
          <li key={name}>
            <span className="form-name">
              ends with {name} <code>{meaning}</code>
            </span>
            {!locked && (
              <button className="link" aria-label={`Remove the end ${name}`} onClick={() => void removeEnd(name)}>
                Remove
              </button>
            )}
          </li>
        ))}
      </ul>
      {!locked && <button onClick={() => void addEnd()}>New end</button>}
      <PortsForm side="input" locked={locked} />
      <PortsForm side="output" locked={locked} />
      <VariablesForm scope="" locked={locked} />
    </>
  );
}

async function removeEnd(name: string): Promise<void> {
  const rest = Object.fromEntries(Object.entries(useRun.getState().task.outcomes).filter(([each]) => each !== name));
  await edit({ do: "set", path: "", key: ["outcomes"], value: rest }, "/");
}

async function addEnd(): Promise<void> {
  const { outcomes } = useRun.getState().task;
  const name = await askText({ title: "New end of the task", label: "Name", initial: "", check: nameCheck(Object.keys(outcomes)) });
  if (name === null) return;
  const options = [
    { value: "success", label: "success" },
    { value: "failure", label: "failure" },
  ];
  const meaning = await askChoice({ title: `What does ${name} mean?`, label: "Meaning", options });
  if (meaning !== null) await edit({ do: "set", path: "", key: ["outcomes"], value: { ...outcomes, [name]: meaning } }, "/");
}

const WORDS: Record<Side, readonly [title: string, about: string, add: string]> = {
  input: ["Inputs", "Given from outside: by the subtask, or by `grip run --set`. One with a value needn't be given.", "New input"],
  output: ["Outputs", "Handed out when the task has ended.", "New output"],
};

export function PortsForm({ side, locked }: { side: Side; locked: boolean }): JSX.Element {
  const variables = useRun((s) => s.task.variables);
  const here = variables.filter((variable) => variable.ports.includes(side));
  const [title, about, add] = WORDS[side];
  return (
    <section aria-label={title}>
      <h3>{title}</h3>
      <p className="hint">{about}</p>
      {here.length > 0 && (
        <ul className="form-list">
          {here.map((variable) => (
            <DeclaredRow key={variable.name} variable={variable} locked={locked} />
          ))}
        </ul>
      )}
      {!locked && <button onClick={() => void newPort(side)}>{add}</button>}
    </section>
  );
}

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
