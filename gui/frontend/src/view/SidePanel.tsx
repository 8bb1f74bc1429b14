/** The selected node in full, and the variables at the shown moment. */
import type { JSX, ReactNode } from "react";

import { IDLE, variableKey } from "../model/status";
import { KINDS, seconds, statusText } from "../model/words";
import type { NodeView, VariableView } from "../protocol/generated";
import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { KindIcon, PhaseIcon } from "./icons";

export function NodePanel(): JSX.Element {
  const selected = usePage((s) => s.selected);
  const node = useRun((s) => (selected === null ? undefined : s.index.byPath.get(selected)));
  return (
    <section className="panel" aria-labelledby="node-title">
      <h2 id="node-title">Node</h2>
      <div className="scroll padded" tabIndex={0} role="group" aria-labelledby="node-title">
        {node ? <NodeFacts node={node} /> : <p className="hint">Select a node in the tree or the outline.</p>}
      </div>
    </section>
  );
}

function NodeFacts({ node }: { node: NodeView }): JSX.Element {
  const status = useRun((s) => s.moment.nodes.get(node.path) ?? IDLE);
  return (
    <>
      <p className="node-title">
        <KindIcon kind={node.kind} /> <strong>{node.name}</strong> <code>{node.path}</code>
      </p>
      <p className={`phase-${status.phase}`}>
        <PhaseIcon phase={status.phase} /> {statusText(status)}
        {status.phase !== "idle" && ` at ${seconds(status.since)}`}
      </p>
      {status.message && <p className="reason">{status.message}</p>}
      {node.doc && <p>{node.doc}</p>}
      <dl>
        <Fact name={node.kind === "leaf" ? "Node" : "Kind"}>{node.kind === "leaf" ? node.label : KINDS[node.kind]}</Fact>
        {node.kind !== "leaf" && node.label && <Fact name="Setting">{node.label}</Fact>}
        <Pairs name="With" pairs={node.parameters} sign="=" />
        <Pairs name="Reads" pairs={node.inputs} sign="←" />
        <Pairs name="Writes" pairs={node.outputs} sign="→" />
        <Pairs name="Outcomes" pairs={node.outcomes} sign=":" />
      </dl>
    </>
  );
}

function Fact({ name, children }: { name: string; children: ReactNode }): JSX.Element {
  return (
    <>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </>
  );
}

function Pairs({ name, pairs, sign }: { name: string; pairs: Record<string, unknown>; sign: string }): JSX.Element | null {
  const entries = Object.entries(pairs);
  if (entries.length === 0) return null;
  return (
    <Fact name={name}>
      {entries.map(([key, value]) => (
        <div key={key}>
          {key === value ? key : `${key}${sign === ":" ? "" : " "}${sign} ${typeof value === "string" ? value : JSON.stringify(value)}`}
        </div>
      ))}
    </Fact>
  );
}

export function VariablesPanel(): JSX.Element {
  const variables = useRun((s) => s.task.variables);
  return (
    <section className="panel" aria-labelledby="variables-title">
      <h2 id="variables-title">Variables</h2>
      <div className="scroll" tabIndex={0} role="group" aria-labelledby="variables-title">
        <table>
          <thead>
            <tr>
              <th scope="col">Name and type</th>
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
  const preview = value?.preview ?? variable.initial ?? "";
  return (
    <tr>
      <th scope="row" title={[variable.doc, `declared at ${variable.scope || "the task"}`].filter(Boolean).join("\n")}>
        {variable.name} <code>{value?.type || variable.type}</code>
      </th>
      <td title={preview}>
        <div className="preview">{preview || <span className="hint">not written</span>}</div>
      </td>
      <td>
        {value && (
          <button className="link" onClick={() => select(value.writer)} title={`${value.writer} at ${seconds(value.t)}`}>
            {value.writer.split("/").at(-1) || "/"}
          </button>
        )}
      </td>
    </tr>
  );
}
