/** The inside of a container as a flow chart: its children with their outcomes as ports, its ends, and what leads where. */
import type { NodeView, TaskView } from "../protocol/generated";
import { join, nameOf, takesChildren } from "./commands";
import { hasEdges, kindOf, kindTitle } from "./kinds";

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
  const machine = hasEdges(around);
  const concurrent = kindOf(around.kind)?.concurrent ?? false;
  const edges = machine ? storedEdges(children, around, within) : derivedEdges(children, around, within, concurrent);
  const led = new Set(edges.map((edge) => `${edge.source}\n${edge.outcome}`));
  const items: FlowItem[] = children.map((node) => item(node, led, concurrent));
  const used = new Set(edges.map((edge) => edge.target));
  const ends = Object.entries(container === "/" && children.length === 0 ? task.outcomes : around.outcomes);
  for (const [outcome, meaning] of ends) {
    const id = endId(outcome, within);
    if (machine || used.has(id)) items.push({ id, kind: "end", outcome, meaning, ports: [], ...END_SIZE });
  }
  const first = takesChildren(around) ? children.find((node) => node.initial) : undefined;
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

/** What follows from the kind of a container, as edges; exits stand in the file and come first. */
function derivedEdges(children: readonly NodeView[], around: NodeView, within: string, concurrent: boolean): FlowEdge[] {
  const edges: FlowEdge[] = [];
  for (const node of children) {
    const exits = new Map(node.on.map((edge) => [edge.outcome, edge.target]));
    for (const [outcome, target] of exits) {
      edges.push({ id: `${node.path}.${outcome}`, source: node.path, target: endId(target, within), outcome, derived: false, label: "" });
    }
    for (const [outcome, meaning] of Object.entries(node.outcomes)) {
      if (exits.has(outcome) || concurrent) continue;
      const lead = node.derived.find((edge) => edge.outcome === meaning) ?? { target: meaning, ends: true };
      const target = lead.ends ? endId(lead.target, within) : join(around.path, lead.target);
      const label = target === node.path ? ["again", around.label].filter(Boolean).join(", ") : "";
      edges.push({ id: `${node.path}.${outcome}`, source: node.path, target, outcome, derived: true, label });
    }
  }
  return edges;
}

function stripOf(around: NodeView): string {
  const face = kindOf(around.kind);
  if (face?.edges) return "";
  if (face?.concurrent) return `All at once: ${around.label || "every child has to succeed"}.`;
  return `Dotted edges follow from the ${kindTitle(around.kind)}; ${around.label || "its order decides"}.`;
}

/** The name under which an item is known as a target of an edge. */
export function targetName(id: string): string {
  const end = id.indexOf("#end:");
  return end >= 0 ? id.slice(end + 5) : nameOf(id);
}
