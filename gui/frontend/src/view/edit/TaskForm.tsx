/** What the task as a whole says: its documentation, how it ends, its variables. */
import type { JSX } from "react";

import { askChoice, askText } from "../../store/ask";
import { edit } from "../../store/editing";
import { nameCheck } from "../../store/gestures";
import { useRun } from "../../store/run";
import { CommentForm } from "./CommentForm";
import { ValueField } from "./fields";
import { PortsForm } from "./PortsForm";
import { VariablesForm } from "./VariablesForm";

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
