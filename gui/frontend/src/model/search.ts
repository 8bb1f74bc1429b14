/** What a search looks through: one entry a node, with everything that it says. */
import type { TaskView } from "../protocol/generated";
import { kindTitle } from "./kinds";

export interface Finding {
  readonly value: string;
  readonly label: string;
  readonly detail: string;
  readonly mark: string;
}

export function findings(task: TaskView): Finding[] {
  const variables = task.variables.map((variable) => ({
    value: `${variable.scope || "/"}\nvariable ${variable.name}`,
    label: variable.name,
    detail: [`${variable.type} of ${variable.scope || "the task"}`, variable.doc].filter(Boolean).join(": "),
    mark: "variable",
  }));
  const nodes = task.nodes.map((node) => ({
    value: node.path,
    label: node.path === "/" ? task.name : node.path,
    detail: [node.label, said(node.parameters), pairs(node.inputs, "←"), pairs(node.outputs, "→"), said(node.fields), node.doc].filter(Boolean).join(" · "),
    mark: kindTitle(node.kind),
  }));
  return [...nodes, ...variables];
}

function said(fields: Record<string, unknown>): string {
  return Object.entries(fields)
    .filter(([key]) => key !== "doc")
    .map(([key, value]) => `${key}: ${typeof value === "string" ? value : JSON.stringify(value)}`)
    .join(", ");
}

function pairs(ports: Record<string, string>, sign: string): string {
  return Object.entries(ports)
    .map(([port, variable]) => `${port} ${sign} ${variable}`)
    .join(", ");
}

/** Options that a person may mean: every word occurs; those whose label begins with it come first. */
export function matching<T extends { readonly label: string; readonly detail?: string; readonly mark?: string }>(options: readonly T[], text: string): T[] {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  const first = words[0] ?? "";
  const rank = (option: T): number => {
    const label = option.label.toLowerCase();
    if (label.startsWith(first) || label.split("/").some((part) => part.startsWith(first))) return 0;
    return label.includes(first) ? 1 : 2;
  };
  return options
    .filter((option) => {
      const all = `${option.label} ${option.detail ?? ""} ${option.mark ?? ""}`.toLowerCase();
      return words.every((word) => all.includes(word));
    })
    .map((option, i) => ({ option, i, rank: words.length ? rank(option) : 0 }))
    .sort((a, b) => a.rank - b.rank || a.i - b.i)
    .map(({ option }) => option);
}
