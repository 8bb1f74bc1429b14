/** What a person does to the selected nodes; each gesture is one edit, or one question and then one edit. */
import { addNew, childNames, type Command, connectingFree, freshName, group, join, moving, nameOf, parentOf, pasting, removal, type Spot, spotFor, takesChildren, topmost, wrapping } from "../model/commands";
import { edgedKind, hasEdges, kindOf, kinds, kindTitle, settingsFor } from "../model/kinds";
import { NEW_COMPONENT, toBeMade } from "../model/parts";
import { server } from "../protocol/client";
import type { KindView, NodeFace, NodeView, Part, PortFace } from "../protocol/generated";
import { askChoice, askText, type Option } from "./ask";
import { provided } from "./begin";
import { useDocument } from "./document";
import { edit } from "./editing";
import { goToTree, usePage } from "./page";
import { useRun } from "./run";

const nodes = (): ReadonlyMap<string, NodeView> => useRun.getState().index.byPath;
export const selection = (): string[] => topmost(useRun.getState().task, usePage.getState().marked);
const report = (words: string): void => useRun.getState().setError(words);

export function nameCheck(taken: readonly string[]): (name: string) => string {
  return (name) => {
    if (!/^[A-Za-z_][A-Za-z0-9_ -]*$/.test(name)) return "Use letters, digits, _, - and spaces; start with a letter or _.";
    return taken.includes(name) ? "A sibling has this name already." : "";
  };
}

/** What can be added, as options: leaves, then containers. */
export function paletteOptions(): Option[] {
  const { catalog } = useDocument.getState();
  const first = (doc: string): string => doc.split("\n")[0] ?? "";
  return [
    ...catalog.nodes.map((face) => ({ value: face.id, label: face.id, detail: first(face.doc), mark: "leaf" })),
    ...toBeMade(catalog.nodes).map((face) => ({ value: face.id, label: face.id === NEW_COMPONENT ? "a new component" : face.id, detail: face.doc, mark: "to be made" })),
    ...subtasks().map((face) => ({ value: face.id, label: face.id, detail: first(face.doc), mark: "subtask" })),
    ...kinds().filter((face) => face.kind !== "subtask").map((face) => ({ value: face.kind, label: face.title, detail: first(face.doc), mark: "container" })),
  ];
}

/** Add a node of the palette: at a spot, or where the selection says. */
export async function add(what: string, at?: Spot): Promise<void> {
  const focus = focusPath();
  const spot = at ?? spotFor(nodes(), focus);
  if (spot === null) {
    report("No container takes another child: wrap the root in a sequence first.");
    return;
  }
  if (!(await provided(what, (node) => add(node, at)))) return;
  // Who adds faster than the answers come means the place after the node, wherever that is by then.
  const made: string[] = [];
  const command = (): Command => {
    const { command, path } = addNew(useRun.getState().task, nodes(), useDocument.getState().catalog, what, at ?? spotFor(nodes(), focus) ?? spot);
    made.splice(0, 1, path);
    return command;
  };
  await edit(command, made, `${what.split("/").at(-1)} was added to ${spot.parent}`);
}

/** Tasks that this one may run: the others. */
export function subtasks(): readonly NodeFace[] {
  const { catalog, document } = useDocument.getState();
  return catalog.tasks.filter((face) => face.id !== document?.path);
}

/** In the flow chart something new goes into the container that is shown. */
function focusPath(): string | null {
  const { selected, view, container } = usePage.getState();
  if (view !== "flow") return selected;
  return selected !== null && parentOf(selected) === container ? selected : container;
}

export async function addHere(): Promise<void> {
  const what = await askChoice({ title: "Add a node", label: "Type to find a node or a container", options: paletteOptions() });
  if (what === null) return;
  await add(what);
  goToTree();
}

export async function rename(path = usePage.getState().selected): Promise<void> {
  if (path === null) return;
  const parent = parentOf(path);
  if (parent === null) {
    const name = await askText({ title: "Rename the task", label: "Name", initial: useRun.getState().task.name });
    if (name !== null) await edit({ do: "set", path: "", key: ["name"], value: name });
    return;
  }
  const taken = childNames(nodes(), parent).filter((name) => name !== nameOf(path));
  const name = await askText({ title: `Rename ${nameOf(path)}`, label: "Name", initial: nameOf(path), check: nameCheck(taken) });
  if (name !== null && name !== nameOf(path)) await edit({ do: "rename", path, name }, join(parent, name), `renamed to ${name}`);
}

export async function remove(): Promise<void> {
  const paths = selection();
  if (paths.includes("/")) return report("The root can't be removed; change its kind, or remove what is in it.");
  if (paths.length > 0) await edit(removal(paths), undefined, `${paths.length === 1 ? paths[0] : `${paths.length} nodes`} removed`);
}

export async function copy(): Promise<boolean> {
  const { document } = useDocument.getState();
  const paths = selection();
  if (document === null || paths.length === 0) return false;
  try {
    const parts = await server.parts(document.path, paths);
    keepParts(parts);
    useDocument.getState().say(`${parts.length === 1 ? parts[0]?.name : `${parts.length} nodes`} copied`);
    return true;
  } catch (error) {
    report(error instanceof Error ? error.message : String(error));
    return false;
  }
}

export async function cut(): Promise<void> {
  if (await copy()) await remove();
}

export async function paste(at?: Spot): Promise<void> {
  const parts = keptParts();
  const spot = at ?? spotFor(nodes(), focusPath());
  if (parts.length === 0) return report("Nothing was copied yet.");
  if (spot === null) return report("No container here takes another child.");
  const { command, paths } = pasting(nodes(), parts, spot);
  await edit(command, paths, `${parts.length === 1 ? parts[0]?.name : `${parts.length} nodes`} pasted`);
}

export async function duplicate(): Promise<void> {
  if (await copy()) await paste();
}

export async function wrap(kind?: string): Promise<void> {
  const paths = selection();
  if (paths.length === 0) return;
  const offered = kinds().filter((face) => face.holds === "many" || (face.holds === "one" && paths.length === 1));
  const chosen = kind ?? (await askChoice({ title: `Wrap ${paths.length === 1 ? paths[0] : `${paths.length} nodes`} in`, label: "Container", options: offered.map(kindOption) }));
  if (chosen === null) return;
  const { command, path } = wrapping(nodes(), paths, chosen);
  await edit(command, path, `wrapped in a ${kindTitle(chosen)}`);
}

function kindOption(face: KindView): Option {
  return { value: face.kind, label: face.title, detail: face.doc.split("\n")[0] ?? "" };
}

export async function unwrap(): Promise<void> {
  const path = usePage.getState().selected;
  if (path !== null) await edit({ do: "unwrap", path }, parentOf(path) ?? "/", `${path} unwrapped`);
}

export async function renameOutcome(node: NodeView, outcome: string): Promise<void> {
  const check = nameCheck(Object.keys(node.outcomes).filter((each) => each !== outcome));
  const name = await askText({ title: `Rename the outcome ${outcome}`, label: "Name", initial: outcome, hint: "Edges, exits and rules that name it follow.", check });
  if (name !== null && name !== outcome) await edit({ do: "rename_outcome", path: node.path, outcome, to: name }, node.path);
}

export async function changeKind(path = usePage.getState().selected): Promise<void> {
  const node = path === null ? undefined : nodes().get(path);
  if (node === undefined || path === null) return;
  const { catalog } = useDocument.getState();
  if (node.kind === "leaf") {
    const options = catalog.nodes.map((face) => ({ value: face.id, label: face.id, detail: face.doc.split("\n")[0] ?? "" }));
    const id = await askChoice({ title: `Which node is ${node.name}?`, label: "Node", options });
    if (id !== null) await edit({ do: "set", path, key: ["node"], value: id }, path);
    return;
  }
  const fitting = kinds().filter((face) => face.kind !== node.kind && face.holds === kindOf(node.kind)?.holds);
  const kind = await askChoice({ title: `Change the kind of ${node.name}`, label: "Kind", options: fitting.map(kindOption) });
  if (kind === null) return;
  const toEdges = kindOf(kind)?.edges === true && !hasEdges(node);
  const title = `change ${node.name} to a ${kindTitle(kind)}`;
  await edit(toEdges ? group(title, withEdges(node, kind)) : { do: "change_kind", path, kind, fields: kindFields(kind, node) }, path, `now a ${kindTitle(kind)}`);
}

/** Settings that a node needs to be of another kind; it keeps its outcomes. */
export function kindFields(kind: string, node: NodeView): Record<string, unknown> {
  const { outcomes: _, ...fields } = settingsFor(kind, node.children.map(nameOf));
  return fields;
}

/** Make a container one whose edges say who is next: its order becomes edges, but for outcomes that a child hasn't. */
export function withEdges(around: NodeView, kind = edgedKind()): Command[] {
  const lacks = around.children.flatMap((path) => {
    const outcomes = nodes().get(path)?.outcomes ?? {};
    return Object.keys(outcomes).length === 0 ? [] : ["success", "failure"].filter((each) => !(each in outcomes)).map((outcome) => ({ do: "disconnect", path, outcome }));
  });
  return [{ do: "change_kind", path: around.path, kind, fields: kindFields(kind, around) }, ...lacks];
}

/** Move the selected nodes among their siblings, or out of and into containers. */
export async function shift(where: "up" | "down" | "out" | "in"): Promise<void> {
  const paths = selection();
  const first = paths[0];
  const parent = first === undefined ? null : parentOf(first);
  if (first === undefined || parent === null) return;
  const spot = spotOf(where, paths, parent);
  if (spot === null) return useDocument.getState().say("It cannot be moved further");
  const { command, paths: now } = moving(nodes(), paths, spot);
  await edit(command, now, `moved ${where}, now in ${spot.parent}`);
}

function spotOf(where: string, paths: readonly string[], parent: string): Spot | null {
  const siblings = nodes().get(parent)?.children ?? [];
  const at = siblings.indexOf(paths[0] as string);
  const last = siblings.indexOf(paths.at(-1) as string);
  if (where === "up") return at > 0 ? { parent, index: at - 1 } : null;
  if (where === "down") return last >= 0 && last < siblings.length - 1 ? { parent, index: last + 2 } : null;
  if (where === "in") {
    const before = siblings[at - 1];
    const node = before === undefined ? undefined : nodes().get(before);
    return takesChildren(node) ? { parent: before as string, index: (node as NodeView).children.length } : null;
  }
  return spotAfter(parent);
}

function spotAfter(path: string): Spot | null {
  const parent = parentOf(path);
  if (parent === null) return null;
  const node = nodes().get(parent);
  return takesChildren(node) ? { parent, index: (node as NodeView).children.indexOf(path) + 1 } : spotAfter(parent);
}

/** Drop dragged nodes at a spot. */
export async function dropAt(paths: readonly string[], spot: Spot): Promise<void> {
  const tops = topmost(useRun.getState().task, paths);
  if (tops.length === 0 || tops.includes("/")) return;
  const { command, paths: now } = moving(nodes(), tops, spot);
  await edit(command, now, `moved to ${spot.parent}`);
}

export async function connectFree(path?: string): Promise<void> {
  const { selected, container } = usePage.getState();
  const candidates = [path, selected, selected === null ? null : parentOf(selected), container];
  const machine = candidates.find((each) => each && hasEdges(nodes().get(each)));
  const command = machine ? connectingFree(nodes(), machine) : null;
  if (command === null && machine) return useDocument.getState().say("Every outcome leads somewhere already.");
  if (command === null) return report("Select a state machine, or a node in one.");
  await edit(command, undefined, "free outcomes connected");
}

export async function newVariable(scope: string): Promise<void> {
  const taken = useRun.getState().task.variables.filter((v) => v.scope === scope).map((v) => v.name);
  const name = await askText({ title: "New variable", label: "Name", initial: "", check: nameCheck(taken) });
  if (name === null) return;
  const type = await askText({ title: `Type of ${name}`, label: "Type", initial: "PointCloud", hint: "A value type, int, float, str, bool, list[T], dict[str, T], T | None, a ROS type, or Any" });
  if (type !== null) await edit({ do: "declare", path: scope, name, variable: type });
}

/** A variable of the task for a port, of the port's type: declared and bound at once. */
export async function newVariableFor(path: string, side: "in" | "out", port: PortFace): Promise<void> {
  const taken = useRun.getState().task.variables.filter((v) => v.scope === "").map((v) => v.name);
  const name = await askText({ title: `New variable for ${port.name}`, label: "Name", initial: freshName(taken, port.name), check: nameCheck(taken), hint: `Of the type ${port.type}` });
  if (name === null) return;
  const commands = [{ do: "declare", path: "", name, variable: port.type }, { do: "set", path, key: [side, port.name], value: name }];
  await edit(group(`new variable ${name}`, commands));
}

const KEY = "grip.clipboard";

export function keepParts(parts: readonly Part[]): void {
  localStorage.setItem(KEY, JSON.stringify(parts));
}

export function keptParts(): Part[] {
  try {
    const parts: unknown = JSON.parse(localStorage.getItem(KEY) ?? "[]");
    return Array.isArray(parts) ? (parts as Part[]) : [];
  } catch {
    return [];
  }
}
