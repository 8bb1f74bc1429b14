/** Variables and ports: declared, changed, renamed, taken out. */
import { type Command, group } from "../model/commands";
import type { VariableView } from "../protocol/generated";
import { askText } from "./ask";
import { edit } from "./editing";
import { nameCheck } from "./gestures";
import { useRun } from "./run";

export type Side = VariableView["ports"][number];

const KEYS: Record<Side, string> = { input: "inputs", output: "outputs" };
const TYPES = "A value type, int, float, str, bool, list[T], dict[str, T], T | None, a ROS type, or Any";

/** A new port of the task; one that is on the other side already becomes one that goes in and comes out. */
export async function newPort(side: Side): Promise<void> {
  const { variables } = useRun.getState().task;
  const other = variables.filter((each) => each.ports.length === 1 && each.ports[0] !== side);
  const taken = variables.filter((each) => each.scope === "" && !other.includes(each)).map((each) => each.name);
  const name = await askText({ title: `New ${side}`, label: "Name", initial: "", check: nameCheck(taken), hint: "The name of a port on the other side makes it an in/out port" });
  if (name === null) return;
  const both = other.find((each) => each.name === name);
  const type = both?.type ?? (await askText({ title: `Type of ${name}`, label: "Type", initial: "PointCloud", hint: TYPES }));
  if (type !== null) await edit({ do: "set", path: "", key: [KEYS[side], name], value: type });
}

/** Change the type or the initial value (undefined: none at first); what else is said of it stays. */
export async function redeclare({ scope, name }: VariableView, change: Change): Promise<void> {
  await edit(() => {
    const now = useRun.getState().task.variables.find((each) => each.scope === scope && each.name === name);
    return now === undefined ? group("", []) : redeclaring(now, change);
  });
}

interface Change {
  readonly type?: string;
  readonly value?: unknown;
}

function redeclaring(variable: VariableView, change: Change): Command {
  const { scope, name, doc, ports, initial } = variable;
  const type = change.type ?? variable.type;
  const value = "value" in change ? change.value : initial === null ? undefined : (JSON.parse(initial) as unknown);
  const declared = (withValue: boolean): unknown => {
    const valued = withValue && value !== undefined;
    return valued || doc !== "" ? { type, ...(valued ? { value } : {}), ...(doc !== "" ? { doc } : {}) } : type;
  };
  if (ports.length < 2) return { do: "set", path: scope, key: [ports[0] ? KEYS[ports[0]] : "data", name], value: declared(true) };
  // What goes in and comes out is declared twice, with one type, and so changed at once; the value is that of the input.
  const steps = ports.map((side) => ({ step: "assign", at: [KEYS[side]], key: name, value: declared(side === "input") }));
  return { do: "patch", title: `change ${name}`, steps };
}

export async function renameVariable({ scope, name }: VariableView): Promise<void> {
  const taken = useRun.getState().task.variables.filter((each) => each.scope === scope && each.name !== name).map((each) => each.name);
  const to = await askText({ title: `Rename the variable ${name}`, label: "Name", initial: name, check: nameCheck(taken), hint: "Bindings and expressions follow." });
  if (to !== null && to !== name) await edit({ do: "rename_variable", path: scope, name, to });
}

export async function removeDeclared({ scope, name }: VariableView): Promise<void> {
  await edit({ do: "undeclare", path: scope, name });
}
