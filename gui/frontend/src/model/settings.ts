/** What a node is set to, as a person reads it near at hand: parameters, settings of its kind, ports. */
import type { NodeView } from "../protocol/generated";

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
