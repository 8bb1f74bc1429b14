/** The inside of a container as a flow chart: its children with their outcomes as ports, its ends, and what leads where. */
import type { NodeView, TaskView } from "../protocol/generated";
import { join, nameOf, takesChildren } from "./commands";
import { hasEdges, kindOf, kindTitle } from "./kinds";

/** Where an edge enters a box and its first outcome leaves it, below the top: at one height, so that a chain is a line. */
export const LEAD = 23;
export const PORT_HEIGHT = 20;
export const FLOW_HEAD = 46;
const WIDEST = 250;
const START_SIZE = { width: 20, height: 20 };
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
  /** What the outcome means to what is around: success, failure, or nothing. */
  readonly meaning: string;
  /** What stands on it. */
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
export const isEnd = (id: string): boolean => id.includes("#end:");
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
  const bare = machine ? storedEdges(children, around, within) : derivedEdges(children, around, within, concurrent);
  const led = new Set(bare.map((edge) => `${edge.source}\n${edge.outcome}`));
  const items: FlowItem[] = children.map((node) => item(node, led, concurrent));
  const meanings = new Map(items.flatMap(({ id, ports }) => ports.map((port) => [`${id}\n${port.outcome}`, port.meaning])));
  const edges: FlowEdge[] = bare.map((edge) => ({ ...edge, label: edge.label || edge.outcome, meaning: meanings.get(`${edge.source}\n${edge.outcome}`) ?? "" }));
  const used = new Set(edges.map((edge) => edge.target));
  const ends = Object.entries(container === "/" && children.length === 0 ? task.outcomes : around.outcomes);
  for (const [outcome, meaning] of ends) {
    const id = endId(outcome, within);
    if (machine || used.has(id)) items.push({ id, kind: "end", outcome, meaning, ports: [], width: Math.max(96, textWidth(outcome, 14) + 56), height: 34 });
  }
  const first = takesChildren(around) ? children.find((node) => node.initial) : undefined;
  if (first) {
    const id = within + START;
    items.unshift({ id, kind: "start", ports: [], ...START_SIZE });
    edges.unshift({ id, source: id, target: first.path, outcome: "", derived: true, meaning: "", label: "" });
  }
  return { items, edges, strip: stripOf(around), machine };
}

/** In which order outcomes stand at a box: success first, what means nothing before failures. */
export const rank = (meaning: string): number => ({ success: 0, failure: 2 })[meaning] ?? 1;

/** Room for a text [px], whatever the font: wide letters count twice, and nothing is covered by words that are a little longer. */
export function textWidth(text: string, size: number): number {
  let wide = 0;
  for (const letter of text) wide += (letter.codePointAt(0) as number) > 0x2e7f ? 1.1 : 0.58;
  return Math.ceil(wide * size);
}

/** What a node is, in small print. */
export function subtitleOf(node: NodeView): string {
  const kind = node.kind === "leaf" ? node.label : [kindTitle(node.kind), node.label].filter(Boolean).join(", ");
  return node.children.length > 0 ? `${kind}: ${node.children.length} inside` : kind;
}

/** An outcome that leads nowhere has its name in the box: it is what one drags. */
export const freeWidth = (ports: readonly Port[]): number => Math.max(0, ...ports.filter((port) => !port.led).map((port) => textWidth(port.outcome, 12) + 30));

function sizeOf(node: NodeView, ports: readonly Port[]): { width: number; height: number } {
  const head = textWidth(node.name, 13) + (node.children.length > 0 ? 90 : 66);
  const wide = Math.min(WIDEST, Math.max(132, head, textWidth(subtitleOf(node), 12) + 40));
  return { width: wide + freeWidth(ports), height: Math.max(FLOW_HEAD + 2, LEAD + (ports.length - 1) * PORT_HEIGHT + 17) };
}

/** @param without whether what is around has no edges, so that no outcome waits for one. */
function item(node: NodeView, led: ReadonlySet<string>, without: boolean): FlowItem {
  const finer = node.on.map((edge) => edge.outcome).filter((outcome) => !(outcome in node.outcomes));
  const ports = [...Object.keys(node.outcomes), ...finer].map((outcome) => ({
    outcome,
    meaning: node.outcomes[outcome.split(".")[0] as string] ?? "failure",
    led: without || led.has(`${node.path}\n${outcome}`),
  }));
  ports.sort((a, b) => rank(a.meaning) - rank(b.meaning));
  return { id: node.path, kind: "node", node, ports, ...sizeOf(node, ports) };
}

type BareEdge = Omit<FlowEdge, "meaning">;

function storedEdges(children: readonly NodeView[], around: NodeView, within: string): BareEdge[] {
  const edges: BareEdge[] = [];
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
function derivedEdges(children: readonly NodeView[], around: NodeView, within: string, concurrent: boolean): BareEdge[] {
  const edges: BareEdge[] = [];
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

/**
 * Followed along success first, an edge to what is still under way closes a loop; without these edges the chart has no
 * circles, and its order begins with the path of success.
 * @param first where it begins.
 */
export function readingOrder(ids: readonly string[], edges: readonly FlowEdge[], first: string | undefined): string[] {
  const after = new Map<string, FlowEdge[]>(ids.map((id) => [id, []]));
  for (const edge of edges) if (after.has(edge.target) && edge.source !== edge.target) after.get(edge.source)?.push(edge);
  for (const list of after.values()) list.sort((a, b) => rank(a.meaning) - rank(b.meaning));
  const roots = [...ids].sort((a, b) => Number(b === first) - Number(a === first));
  const loops = loopsOf(roots, after);
  const waits = new Map(ids.map((id) => [id, 0]));
  const wait = (id: string, by: number): number => {
    const now = (waits.get(id) ?? 0) + by;
    waits.set(id, now);
    return now;
  };
  for (const list of after.values()) for (const edge of list) if (!loops.has(edge)) wait(edge.target, 1);
  const ready = roots.filter((id) => waits.get(id) === 0).reverse();
  const order: string[] = [];
  for (let id = ready.pop(); id !== undefined; id = ready.pop()) {
    order.push(id);
    const next = (after.get(id) ?? []).filter((edge) => !loops.has(edge) && wait(edge.target, -1) === 0);
    ready.push(...next.map((edge) => edge.target).reverse());
  }
  return order;
}

/** Edges to what is still under way, when they are followed depth first. */
function loopsOf(roots: readonly string[], after: ReadonlyMap<string, FlowEdge[]>): Set<FlowEdge> {
  const under_way = new Map<string, boolean>();
  const loops = new Set<FlowEdge>();
  for (const root of roots) {
    if (under_way.has(root)) continue;
    const stack: [string, number][] = [[root, 0]];
    under_way.set(root, true);
    for (let top = stack.at(-1); top !== undefined; top = stack.at(-1)) {
      const edge = after.get(top[0])?.[top[1]++];
      if (edge === undefined) {
        under_way.set(top[0], false);
        stack.pop();
      } else if (under_way.get(edge.target)) loops.add(edge);
      else if (!under_way.has(edge.target)) {
        under_way.set(edge.target, true);
        stack.push([edge.target, 0]);
      }
    }
  }
  return loops;
}
