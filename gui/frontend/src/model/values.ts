/** Literals as a person types them, and back. */
import type { NodeView } from "../protocol/generated";
import type { TaskIndex } from "./status";

/** A value as it stands in a field: texts of text parameters as they are, everything else as JSON. */
export function valueText(value: unknown, type: string): string {
  if (value === undefined) return "";
  return typeof value === "string" && isText(type) ? value : JSON.stringify(value);
}

export function isText(type: string): boolean {
  return type === "str" || type === "text" || type === "expression" || type === "variable" || type === "child";
}

export type Parsed = { readonly value: unknown } | { readonly fault: string };

/** The value that a text stands for, or why it stands for none. */
export function parseValue(text: string, type: string): Parsed {
  if (isText(type)) return { value: text };
  const plain = text.trim();
  if (type === "int" || type === "float") {
    const number = Number(plain);
    if (plain === "" || !Number.isFinite(number) || (type === "int" && !Number.isInteger(number))) {
      return { fault: type === "int" ? "A whole number is needed." : "A number is needed." };
    }
    return { value: number };
  }
  try {
    return { value: JSON.parse(plain) };
  } catch {
    // A word where anything may stand is a text: `home` needs no quotes.
    if (/^[A-Za-z_][\w ./-]*$/.test(plain) && type !== "json") return { value: plain };
    return { fault: `A literal of type ${type} is needed, as JSON: 1, "text", [1, 2], {"a": 1}.` };
  }
}

/** So many are shown as buttons; more are a list that typing filters. */
export const FEW = 6;

/** Which one an arrow, Home or End leads to, from one to the next and round; null for any other key. */
export function turned(key: string, at: number, count: number): number | null {
  if (count === 0) return null;
  if (key === "ArrowDown" || key === "ArrowRight") return (at + 1) % count;
  if (key === "ArrowUp" || key === "ArrowLeft") return (Math.max(at, 0) + count - 1) % count;
  if (key === "Home") return 0;
  return key === "End" ? count - 1 : null;
}

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

export interface SettingText {
  readonly name: string;
  readonly text: string;
}

/** In the order of the file; what a node says of its outcomes and children stands elsewhere on it. */
export function settingsOf(node: NodeView): SettingText[] {
  const said = (name: string, value: unknown): SettingText => ({ name, text: typeof value === "string" ? value : JSON.stringify(value) });
  return [
    ...Object.entries(node.parameters).map(([name, value]) => said(name, value)),
    ...Object.entries(node.fields).filter(([name]) => name !== "doc").map(([name, value]) => said(name, value)),
    ...Object.entries(node.inputs).map(([port, variable]) => ({ name: port, text: `← ${variable}` })),
    ...Object.entries(node.outputs).map(([port, variable]) => ({ name: port, text: `→ ${variable}` })),
  ];
}
