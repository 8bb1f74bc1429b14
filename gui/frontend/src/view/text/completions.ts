/** What may stand at the cursor: keys of the schema, nodes of the catalogue, names of the task. */
import type { Completion, CompletionContext, CompletionResult } from "@codemirror/autocomplete";

import { nameOf } from "../../model/commands";
import { useDocument } from "../../store/document";
import { namesFor, needNames, useNames } from "../../store/names";
import { useRun } from "../../store/run";

const NODE_KEYS = ["node", "kind", "doc", "precondition", "on", "with", "in", "out", "meaning", "data", "outcomes", "exits", "children", "child"];
const TASK_KEYS = ["grip", "name", "doc", "outcomes", "data", "root"];

export function complete(context: CompletionContext): CompletionResult | null {
  const line = context.state.doc.lineAt(context.pos);
  const before = line.text.slice(0, context.pos - line.from);
  const word = /[A-Za-z_][\w/.-]*$/.exec(before)?.[0] ?? "";
  const lead = before.slice(0, before.length - word.length);
  if (word === "" && !context.explicit) return null;
  const options = optionsAfter(lead);
  return options.length > 0 ? { from: context.pos - word.length, options, validFor: /^[\w/.-]*$/ } : null;
}

function optionsAfter(lead: string): Completion[] {
  const { catalog } = useDocument.getState();
  if (/\bnode:\s*$/.test(lead)) return catalog.nodes.map((face) => ({ label: face.id, type: "function", detail: face.doc.split("\n")[0] ?? "" }));
  if (/\bkind:\s*$/.test(lead)) return catalog.kinds.map((face) => ({ label: face.kind, type: "class", detail: face.doc.split("\n")[0] ?? "" }));
  if (/\b(in|out):\s*\{[^}]*\w+:\s*$/.test(lead) || /\bitems:\s*$/.test(lead)) return variables();
  if (/\b(in|out|with):\s*\{([^}]*,\s*)?$/.test(lead)) return ports(lead);
  const given = parameterValues(lead);
  if (given) return given;
  if (/:\s*$/.test(lead)) return [...names(), ...variables()];
  if (/^\s*$/.test(lead)) return (lead === "" ? TASK_KEYS : keys()).map((label) => ({ label, type: "property", apply: `${label}: ` }));
  if (/[{,]\s*$/.test(lead)) return keys().map((label) => ({ label, type: "property", apply: `${label}: ` }));
  return [];
}

function keys(): string[] {
  const fields = useDocument.getState().catalog.kinds.flatMap((face) => face.fields.map((field) => field.key));
  return [...new Set([...NODE_KEYS, ...fields])];
}

function variables(): Completion[] {
  const seen = new Map(useRun.getState().task.variables.map((variable) => [variable.name, variable.type]));
  return [...seen].map(([label, detail]) => ({ label, type: "variable", detail }));
}

function names(): Completion[] {
  const { task } = useRun.getState();
  const nodes = task.nodes.filter((node) => node.path !== "/").map((node) => nameOf(node.path));
  const outcomes = task.nodes.flatMap((node) => Object.keys(node.outcomes));
  return [...new Set([...nodes, ...outcomes])].map((label) => ({ label, type: "constant" }));
}

/** What the project's files name, where the value of a parameter is written in the line of its node. */
function parameterValues(lead: string): Completion[] | null {
  const id = /\bnode:\s*([\w/]+)/.exec(lead)?.[1];
  const parameter = /\bwith:\s*\{(?:[^}]*,)?\s*(\w+):\s*$/.exec(lead)?.[1];
  if (id === undefined || parameter === undefined) return null;
  needNames();
  return namesFor(useNames.getState().places, id, parameter)?.map((label) => ({ label, type: "constant" })) ?? null;
}

/** Ports or parameters of the leaf that this line is about. */
function ports(lead: string): Completion[] {
  const id = /\bnode:\s*([\w/]+)/.exec(lead)?.[1];
  const face = useDocument.getState().catalog.nodes.find((each) => each.id === id);
  const side = /\b(in|out|with):\s*\{[^}]*$/.exec(lead)?.[1];
  const list = side === "with" ? face?.parameters : side === "in" ? face?.inputs : face?.outputs;
  return (list ?? []).map((port) => ({ label: port.name, type: "property", detail: port.type, info: port.doc, apply: `${port.name}: ` }));
}
