/** The inside of a container as a flow chart: its children with their outcomes as ports, its ends, and what leads where. */
import type { NodeView, TaskView } from "../protocol/generated";
import { join, nameOf } from "./commands";

export const FLOW_WIDTH = 208;
export const PORT_HEIGHT = 20;
export const FLOW_HEAD = 46;
const END_SIZE = { width: 132, height: 34 };
const START_SIZE = { width: 28, height: 28 };
/** Id of the mark from which the first child is entered, after the path of its container where that is open in another; no path holds a `#`. */
export const START = "#start";

export interface Port {
  readonly outcome: string;
  readonly meaning: string;
  /** Whether it leads somewhere, or needn't. */
  readonly led: boolean;
}

export interface FlowItem {
  readonly id: string;
  readonly kind: "node" | "end" | "start";
  readonly node?: NodeView;
  /** Of an end: its outcome and meaning. */
  readonly outcome?: string;
  readonly meaning?: string;
  readonly ports: readonly Port[];
  readonly width: number;
  readonly height: number;
}

export interface FlowEdge {
  readonly id: string;
  readonly source: string;
  readonly target: string;
  readonly outcome: string;
  /** Whether it follows from the order or the kind, and isn't one that stands in the file. */
  readonly derived: boolean;
  readonly label: string;
}

export interface Flow {
  readonly items: readonly FlowItem[];
  readonly edges: readonly FlowEdge[];
  /** What edges can't say about this container. */
  readonly strip: string;
  readonly machine: boolean;
}

export const endId = (outcome: string, within = ""): string => `${within}#end:${outcome}`;
export const isStart = (id: string): boolean => id.endsWith(START);

/**
 * The inside of a container.
 * @param within begins the ids of its ends and its start, so that several charts can stand in one.
 */
export function flowOf(task: TaskView, byPath: ReadonlyMap<string, NodeView>, container: string, within = ""): Flow {
  const around = byPath.get(container);
  if (!around) return { items: [], edges: [], strip: "", machine: false };
  const children = around.children.map((path) => byPath.get(path)).filter((node) => node !== undefined);
  const machine = around.kind === "state_machine";
  const edges = machine ? storedEdges(children, around, within) : derivedEdges(children, around, within);
  const led = new Set(edges.map((edge) => `${edge.source}\n${edge.outcome}`));
  const items: FlowItem[] = children.map((node) => item(node, led, around.kind === "parallel"));
  const used = new Set(edges.map((edge) => edge.target));
  const ends = Object.entries(container === "/" && children.length === 0 ? task.outcomes : around.outcomes);
  for (const [outcome, meaning] of ends) {
    const id = endId(outcome, within);
    if (machine || used.has(id)) items.push({ id, kind: "end", outcome, meaning, ports: [], ...END_SIZE });
  }
  const first = machine ? children.find((node) => node.initial) : ORDERED.has(around.kind) ? children[0] : undefined;
  if (first) {
    const id = within + START;
    items.unshift({ id, kind: "start", ports: [], ...START_SIZE });
    edges.unshift({ id, source: id, target: first.path, outcome: "", derived: true, label: "" });
  }
  return { items, edges, strip: stripOf(around), machine };
}

/** @param without whether what is around has no edges, so that no outcome waits for one. */
function item(node: NodeView, led: ReadonlySet<string>, without: boolean): FlowItem {
  const finer = node.on.map((edge) => edge.outcome).filter((outcome) => !(outcome in node.outcomes));
  const ports = [...Object.keys(node.outcomes), ...finer].map((outcome) => ({
    outcome,
    meaning: node.outcomes[outcome.split(".")[0] as string] ?? "failure",
    led: without || led.has(`${node.path}\n${outcome}`),
  }));
  return { id: node.path, kind: "node", node, ports, width: FLOW_WIDTH, height: FLOW_HEAD + ports.length * PORT_HEIGHT + 6 };
}

function storedEdges(children: readonly NodeView[], around: NodeView, within: string): FlowEdge[] {
  const edges: FlowEdge[] = [];
  for (const node of children) {
    for (const { outcome, target } of node.on) {
      const sibling = join(around.path, target);
      const to = around.children.includes(sibling) ? sibling : target in around.outcomes ? endId(target, within) : null;
      if (to !== null) edges.push({ id: `${node.path}.${outcome}`, source: node.path, target: to, outcome, derived: false, label: "" });
    }
  }
  return edges;
}

const ORDERED = new Set(["sequence", "fallback"]);

/** What the order and the kind of a container say, as edges; exits stand in the file and come first. */
function derivedEdges(children: readonly NodeView[], around: NodeView, within: string): FlowEdge[] {
  const edges: FlowEdge[] = [];
  children.forEach((node, i) => {
    const exits = new Map(node.on.map((edge) => [edge.outcome, edge.target]));
    for (const [outcome, target] of exits) {
      edges.push({ id: `${node.path}.${outcome}`, source: node.path, target: endId(target, within), outcome, derived: false, label: "" });
    }
    for (const [outcome, meaning] of Object.entries(node.outcomes)) {
      if (exits.has(outcome)) continue;
      const lead = byKind(around, children, i, meaning, within);
      if (lead) edges.push({ id: `${node.path}.${outcome}`, source: node.path, outcome, derived: true, ...lead });
    }
  });
  return edges;
}

function byKind(around: NodeView, children: readonly NodeView[], i: number, meaning: string, within: string): { target: string; label: string } | null {
  const self = children[i]?.path as string;
  const next = children[i + 1]?.path;
  const end = (outcome: string): { target: string; label: string } => ({ target: endId(outcome, within), label: "" });
  switch (around.kind) {
    case "sequence":
      return meaning === "success" && next ? { target: next, label: "" } : end(meaning);
    case "fallback":
      return meaning === "failure" && next ? { target: next, label: "" } : end(meaning);
    case "retry":
      return meaning === "failure" ? { target: self, label: `again, at most ×${String(around.fields["times"])}` } : end(meaning);
    case "repeat":
    case "loop":
    case "for_each":
      return meaning === "success" ? { target: self, label: "again" } : end(meaning);
    case "invert":
      return end(meaning === "success" ? "failure" : "success");
    case "force":
      return end(String(around.fields["as"] ?? meaning));
    case "parallel":
      return null;
    default:
      return end(meaning);
  }
}

function stripOf(around: NodeView): string {
  if (ORDERED.has(around.kind) && around.fields["memory"] === false) return "Re-checked from the first child on every tick: this has no edges.";
  if (around.kind === "parallel") return `All at once: ${around.label || "every child has to succeed"}.`;
  if (around.kind === "state_machine") return "";
  return `Dotted edges follow from the ${around.kind}; ${around.label || "its order decides"}.`;
}

/** The name under which an item is known as a target of an edge. */
export function targetName(id: string): string {
  const end = id.indexOf("#end:");
  return end >= 0 ? id.slice(end + 5) : nameOf(id);
}
