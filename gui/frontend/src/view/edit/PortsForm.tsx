/** What the task is given from outside, and what it hands out at the end: ports of the subtask that runs it. */
import type { JSX } from "react";

import { newPort, type Side } from "../../store/declaring";
import { useRun } from "../../store/run";
import { DeclaredRow } from "./DeclaredRow";

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
