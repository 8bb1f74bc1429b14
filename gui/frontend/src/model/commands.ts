/** Edits as the server understands them (docs/editing.md), made from what a person points at. */
import type { CatalogView, NodeFace, NodeView, Part, TaskView } from "../protocol/generated";
import { hasEdges, kindOf, kindTitle, newContainer, settingsFor } from "./kinds";

export type Command = Record<string, unknown> & { readonly do: string };
type Nodes = ReadonlyMap<string, NodeView>;

/** A place for new nodes: in a container, before the child at `index`. */
export interface Spot {
  readonly parent: string;
  readonly index: number;
}

export function join(parent: string, name: string): string {
  return parent === "/" ? name : `${parent}/${name}`;
}

export function parentOf(path: string): string | null {
  if (path === "/") return null;
  return path.includes("/") ? path.slice(0, path.lastIndexOf("/")) : "/";
}

export function nameOf(path: string): string {
  return path.slice(path.lastIndexOf("/") + 1);
}

/** Whether it is a container that takes another child. */
export function takesChildren(node: NodeView | undefined): boolean {
  return node !== undefined && kindOf(node.kind)?.holds === "many";
}

export function group(title: string, commands: readonly Command[]): Command {
  return commands.length === 1 ? (commands[0] as Command) : { do: "group", title, commands };
}

/** Where something new goes when `path` is selected: into it, or after it in the nearest container with room. */
export function spotFor(nodes: Nodes, path: string | null): Spot | null {
  let at = path ?? "/";
  const node = nodes.get(at);
  if (takesChildren(node)) return { parent: at, index: (node as NodeView).children.length };
  for (let above = parentOf(at); above !== null; above = parentOf(at)) {
    const parent = nodes.get(above);
    if (takesChildren(parent)) return { parent: above, index: (parent as NodeView).children.indexOf(at) + 1 };
    at = above;
  }
  return null;
}

/** A name that no child of a container has: `look`, `look 2` ... */
export function freshName(taken: Iterable<string>, wanted: string): string {
  const names = new Set(taken);
  const base = /^[A-Za-z_][A-Za-z0-9_ -]*$/.test(wanted) ? wanted : "node";
  if (!names.has(base)) return base;
  for (let n = 2; ; n++) if (!names.has(`${base}_${n}`)) return `${base}_${n}`;
}

export function childNames(nodes: Nodes, path: string): string[] {
  return (nodes.get(path)?.children ?? []).map(nameOf);
}

/** Variables that a node at `path` sees, the inner ones last: name -> type. */
export function visibleVariables(task: TaskView, path: string): Map<string, string> {
  const seen = new Map<string, string>();
  for (const { scope, name, type } of task.variables) {
    if (scope === "" || scope === "/" || scope === path || path.startsWith(`${scope}/`)) seen.set(name, type);
  }
  return seen;
}

/** A leaf as it stands in a file, with its inputs bound where only one variable can be meant. */
export function newLeaf(face: NodeFace, variables: ReadonlyMap<string, string>): Record<string, unknown> {
  const made: Record<string, unknown> = { node: face.id };
  const bound = (ports: NodeFace["inputs"], onlyRequired: boolean): Record<string, string> => {
    const result: Record<string, string> = {};
    for (const port of ports) {
      const fitting = [...variables].filter(([, type]) => type === port.type).map(([name]) => name);
      const meant = fitting.includes(port.name) ? port.name : fitting.length === 1 ? fitting[0] : undefined;
      if (meant !== undefined && (port.required || !onlyRequired || meant === port.name)) result[port.name] = meant;
    }
    return result;
  };
  const inputs = bound(face.inputs, true);
  const outputs = bound(face.outputs.filter((port) => variables.get(port.name) === port.type), false);
  if (Object.keys(inputs).length > 0) made["in"] = inputs;
  if (Object.keys(outputs).length > 0) made["out"] = outputs;
  return made;
}

/** Add a leaf or a container of the palette at a spot. */
export function addNew(task: TaskView, nodes: Nodes, catalog: CatalogView, what: string, spot: Spot): { command: Command; path: string } {
  const file = catalog.tasks.find((face) => face.id === what);
  const leaf = file ?? catalog.nodes.find((face) => face.id === what);
  const wanted = file ? nameOf(what).replace(/\.ya?ml$/, "") : leaf ? nameOf(what) : what;
  const name = freshName(childNames(nodes, spot.parent), wanted);
  const { node: _, ...bound } = leaf ? newLeaf(leaf, visibleVariables(task, spot.parent)) : { node: "" };
  const node = file ? { kind: "subtask", task: file.id, ...bound } : leaf ? { node: leaf.id, ...bound } : newContainer(what);
  return { command: { do: "add", parent: spot.parent, name, node, index: spot.index }, path: join(spot.parent, name) };
}

/** Selected nodes without those that are inside other selected ones, in the order of the task. */
export function topmost(task: TaskView, marked: Iterable<string>): string[] {
  const set = new Set(marked);
  const inside = (path: string): boolean => {
    for (let above = parentOf(path); above !== null; above = parentOf(above)) if (set.has(above)) return true;
    return false;
  };
  return task.nodes.map((node) => node.path).filter((path) => set.has(path) && !inside(path));
}

export function removal(paths: readonly string[]): Command {
  return group(`remove ${paths.length} nodes`, [...paths].reverse().map((path) => ({ do: "remove", path })));
}

/** Move nodes to a spot, in their order; names that are taken there get a number. */
export function moving(nodes: Nodes, paths: readonly string[], spot: Spot): { command: Command; paths: string[] } {
  // The moves are done one after the other, so each counts with those that haven't moved yet: they are done here too.
  const HERE = "#here";
  const rows = [...(nodes.get(spot.parent)?.children ?? [])];
  rows.splice(spot.index, 0, HERE);
  const names = childNames(nodes, spot.parent);
  const commands: Command[] = [];
  const now: string[] = [];
  for (const path of paths) {
    const stays = parentOf(path) === spot.parent;
    const name = stays ? nameOf(path) : freshName(names, nameOf(path));
    if (stays) rows.splice(rows.indexOf(path), 1);
    else names.push(name);
    const index = rows.indexOf(HERE);
    rows.splice(index, 0, path);
    commands.push({ do: "move", path, parent: spot.parent, index, name: name === nameOf(path) ? null : name });
    now.push(join(spot.parent, name));
  }
  return { command: group(`move ${paths.length} nodes`, commands), paths: now };
}

/** Paste copied parts at a spot; the edges between them lead from copy to copy. */
export function pasting(nodes: Nodes, parts: readonly Part[], spot: Spot): { command: Command; paths: string[] } {
  const parent = nodes.get(spot.parent);
  const taken = [...childNames(nodes, spot.parent), ...Object.keys(parent?.outcomes ?? {})];
  const renamed = new Map<string, string>();
  for (const part of parts) {
    const name = freshName(taken, part.name);
    taken.push(name);
    renamed.set(part.name, name);
  }
  const path = (part: Part): string => join(spot.parent, renamed.get(part.name) as string);
  const commands: Command[] = parts.map((clip, i) => ({ do: "paste", parent: spot.parent, clip, name: renamed.get(clip.name), index: spot.index + i }));
  if (hasEdges(parent)) {
    for (const part of parts) {
      for (const [outcome, target] of Object.entries((part.node["on"] ?? {}) as Record<string, string>)) {
        if (renamed.has(target)) commands.push({ do: "connect", path: path(part), outcome, target: renamed.get(target) });
      }
    }
  }
  return { command: group(`paste ${parts.length} nodes`, commands), paths: parts.map(path) };
}

/** Lead every outcome of a state machine's children that leads nowhere: success to the next one, the rest to an end alike. */
export function connectingFree(nodes: Nodes, path: string): Command | null {
  const machine = nodes.get(path);
  if (machine === undefined || !hasEdges(machine)) return null;
  const ends = Object.entries(machine.outcomes);
  const commands: Command[] = [];
  machine.children.forEach((child, i) => {
    const node = nodes.get(child);
    const led = new Set(node?.on.map((edge) => edge.outcome));
    for (const [outcome, meaning] of Object.entries(node?.outcomes ?? {})) {
      if (led.has(outcome)) continue;
      const next = machine.children[i + 1];
      const alike = ends.find(([name]) => name === outcome) ?? ends.find(([, means]) => means === meaning);
      const target = meaning === "success" && next !== undefined ? nameOf(next) : alike?.[0];
      if (target !== undefined) commands.push({ do: "connect", path: child, outcome, target });
    }
  });
  return commands.length > 0 ? { do: "group", title: "connect free outcomes", commands } : null;
}

/** What wraps: settings that the container needs, with the name that it gets. */
export function wrapping(nodes: Nodes, paths: readonly string[], kind: string): { command: Command; path: string } {
  const parent = parentOf(paths[0] as string);
  const fields = settingsFor(kind, paths.map(nameOf));
  const name = parent === null ? "task" : freshName(childNames(nodes, parent), kind);
  const path = parent === null ? "/" : join(parent, name);
  return { command: { do: "wrap", paths, kind, name, fields }, path };
}

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
