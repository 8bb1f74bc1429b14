/** Who writes and who reads a variable, by what the task says. */
import type { NodeView } from "../protocol/generated";
import type { TaskIndex } from "./status";

export interface Use {
  readonly path: string;
  readonly how: "writes" | "reads" | "looks at";
}

export function usesOf(index: TaskIndex, key: string): Use[] {
  const uses: Use[] = [];
  for (const node of index.task.nodes) {
    const isIt = (name: string): boolean => index.variable(node.path, name) === key;
    if (Object.values(node.outputs).some(isIt)) uses.push({ path: node.path, how: "writes" });
    if (Object.values(node.inputs).some(isIt)) uses.push({ path: node.path, how: "reads" });
    else if (expressionNames(node).some(isIt)) uses.push({ path: node.path, how: "looks at" });
  }
  return uses;
}

/** Words of a node's expressions that may be variables. */
export function expressionNames(node: NodeView): string[] {
  const texts = ["precondition", "if", "while", "on_value", "items"].map((key) => node.fields[key]).filter((text) => typeof text === "string");
  return texts.flatMap((text) => (text as string).match(/[A-Za-z_]\w*/g) ?? []);
}
