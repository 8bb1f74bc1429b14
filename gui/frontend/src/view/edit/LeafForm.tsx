/** Parameters and ports of a leaf, as its manifest describes them. */
import { type JSX, useEffect } from "react";

import { visibleVariables } from "../../model/commands";
import type { NodeFace, NodeView, PortFace } from "../../protocol/generated";
import { useDocument } from "../../store/document";
import { edit } from "../../store/editing";
import { newVariableFor } from "../../store/gestures";
import { namesFor, needNames, useNames } from "../../store/tasks";
import { useRun } from "../../store/run";
import { ChoiceField, Prose, ValueField } from "./fields";

const NEW = "\n";

export function LeafForm({ node, locked }: { node: NodeView; locked: boolean }): JSX.Element {
  const known = useFace(node);
  const face = known ?? faceOf(node);
  return (
    <>
      {known === undefined && node.kind === "leaf" && <p className="fault">No node of the catalogue is called {node.label}.</p>}
      {known && (
        <p className="hint">
          <Prose text={known.doc} />
        </p>
      )}
      {face.parameters.length > 0 && <h3>Parameters</h3>}
      <Parameters node={node} face={face} locked={locked} />
      <Ports title="Reads" side="in" ports={face.inputs} bound={node.inputs} node={node} locked={locked} />
      <Ports title="Writes" side="out" ports={face.outputs} bound={node.outputs} node={node} locked={locked} />
    </>
  );
}

/** The parameters of a node as fields; in brief without what they mean. */
export function Parameters({ node, face, locked, brief = false }: { node: NodeView; face: NodeFace; locked: boolean; brief?: boolean }): JSX.Element {
  const names = useNames((s) => s.places);
  const named = face.parameters.some((parameter) => parameter.type === "str");
  useEffect(() => {
    if (named) needNames();
  }, [named]);
  return (
    <>
      {face.parameters.map((parameter) => (
        <ValueField
          key={parameter.name}
          label={parameter.name}
          type={parameter.type}
          doc={brief ? "" : parameter.doc}
          value={node.parameters[parameter.name]}
          placeholder={parameter.required ? "needed" : JSON.stringify(parameter.default ?? null)}
          disabled={locked}
          options={parameter.type === "str" ? namesFor(names, face.id, parameter.name) : undefined}
          set={(value) => void edit(value === undefined ? { do: "unset", path: node.path, key: ["with", parameter.name] } : { do: "set", path: node.path, key: ["with", parameter.name], value })}
        />
      ))}
    </>
  );
}

/** What the catalogue says about a leaf or a subtask; undefined where it doesn't know it. */
export function useFace(node: NodeView): NodeFace | undefined {
  return useDocument((s) => [...s.catalog.nodes, ...s.catalog.tasks].find((face) => face.id === node.label));
}

/** What can be said of a node that the catalogue doesn't have: what stands in the file. */
function faceOf(node: NodeView): NodeFace {
  const port = (name: string): PortFace => ({ name, type: "Any", doc: "", required: false });
  return {
    id: node.label,
    doc: "",
    parameters: Object.keys(node.parameters).map((name) => ({ name, type: "Any", doc: "", required: false, default: null })),
    inputs: Object.keys(node.inputs).map(port),
    outputs: Object.keys(node.outputs).map(port),
    outcomes: node.outcomes,
    codes: [],
  };
}

interface PortsProps {
  readonly title: string;
  readonly side: "in" | "out";
  readonly ports: readonly PortFace[];
  readonly bound: Record<string, string>;
  readonly node: NodeView;
  readonly locked: boolean;
}

function Ports({ title, side, ports, bound, node, locked }: PortsProps): JSX.Element | null {
  const task = useRun((s) => s.task);
  if (ports.length === 0) return null;
  const variables = [...visibleVariables(task, node.path)];
  const options = (port: PortFace): [string, string][] => {
    const fits = ([, type]: [string, string]): boolean => type === port.type || type === "Any" || port.type === "Any";
    const ordered = [...variables.filter(fits), ...variables.filter((variable) => !fits(variable))];
    return [["", port.required ? "(needed)" : "(not bound)"], ...ordered.map(([name, type]): [string, string] => [name, `${name}: ${type}`]), [NEW, "New variable ..."]];
  };
  const set = (port: PortFace, variable: string): void => {
    if (variable === NEW) void newVariableFor(node.path, side, port);
    else if (variable === "") void edit({ do: "unset", path: node.path, key: [side, port.name] });
    else void edit({ do: "set", path: node.path, key: [side, port.name], value: variable });
  };
  return (
    <>
      <h3>{title}</h3>
      {ports.map((port) => (
        <ChoiceField key={port.name} label={port.name} mark={port.type} doc={port.doc} value={bound[port.name] ?? ""} options={options(port)} disabled={locked} set={(variable) => set(port, variable)} />
      ))}
    </>
  );
}
