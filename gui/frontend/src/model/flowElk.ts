/** The chart of one container as a graph for ELK's layered layout, and its answer as boxes and lines. */
import type { ElkExtendedEdge, ElkLabel, ElkNode, ElkPort } from "elkjs/lib/elk-api";
import { type Flow, FLOW_HEAD, type FlowEdge, type FlowItem, LEAD, PORT_HEIGHT, readingOrder, textWidth } from "./flow";
import type { Box, Point } from "./layout";
import { tidied } from "./flowRoute";

/** Lays out a graph: in the page in a worker, in tests here. */
export type Lay = (graph: ElkNode) => Promise<ElkNode>;

export interface Line {
  readonly points: readonly Point[];
  /** The middle of its words. */
  readonly label: Point | null;
}

/** The inside of a container, laid out. Everything is relative to its upper left corner. */
export interface Level {
  readonly boxes: ReadonlyMap<string, Box>;
  readonly lines: ReadonlyMap<string, Line>;
  /** Of an open container: where its outcomes (and, as the empty one, its entry) are on its border. */
  readonly ports: ReadonlyMap<string, Point>;
  readonly width: number;
  readonly height: number;
}

export const LABEL_HEIGHT = 15;
/** With the room between a dot and its words. */
export const labelWidth = (text: string): number => textWidth(text, 11) + 16;
/** Above what is inside an open container. */
export const OPEN_TOP = FLOW_HEAD + 12;
/** Above so many nodes the order of crossings is looked for less long. */
const MANY = 100;

const OPTIONS: Record<string, string> = {
  "elk.algorithm": "layered",
  "elk.direction": "RIGHT",
  "elk.edgeRouting": "ORTHOGONAL",
  "elk.layered.considerModelOrder.strategy": "NODES_AND_EDGES",
  "elk.layered.considerModelOrder.longEdgeStrategy": "EQUAL",
  "elk.layered.cycleBreaking.strategy": "MODEL_ORDER",
  "elk.layered.nodePlacement.strategy": "BRANDES_KOEPF",
  "elk.layered.nodePlacement.bk.edgeStraightening": "IMPROVE_STRAIGHTNESS",
  "elk.layered.nodePlacement.favorStraightEdges": "true",
  "elk.layered.feedbackEdges": "true",
  "elk.layered.thoroughness": "3",
  "elk.randomSeed": "1",
  "elk.separateConnectedComponents": "false",
  "elk.spacing.nodeNode": "28",
  "elk.spacing.edgeNode": "14",
  "elk.spacing.edgeEdge": "10",
  "elk.layered.spacing.nodeNodeBetweenLayers": "40",
  "elk.layered.spacing.edgeNodeBetweenLayers": "14",
  "elk.layered.spacing.edgeEdgeBetweenLayers": "10",
  "elk.spacing.edgeLabel": "3",
};
const QUICK: Record<string, string> = {
  ...OPTIONS,
  "elk.layered.thoroughness": "1",
  "elk.layered.considerModelOrder.strategy": "NONE",
  "elk.layered.cycleBreaking.strategy": "GREEDY",
  "elk.layered.crossingMinimization.greedySwitch.type": "OFF",
};
/** Ways to place nodes within their layers: the first takes the least room and is nearly always the straightest. */
export const PLACEMENTS: readonly Record<string, string>[] = [
  {},
  { "elk.layered.nodePlacement.bk.fixedAlignment": "LEFTDOWN" },
  { "elk.layered.nodePlacement.strategy": "NETWORK_SIMPLEX" },
];
const portId = (id: string, outcome: string): string => `${id}\n${outcome}`;
/** The container itself, whose border has the ends of what is inside. */
const BORDER = "#border";

/**
 * The graph of a container.
 * @param inside levels of the containers that are open in it.
 * @param open the container's own box, where it is open in another chart: its ends and its start are ports on its border.
 */
export function graphOf(flow: Flow, inside: ReadonlyMap<string, Level>, open: FlowItem | null, placement: Record<string, string> = {}): ElkNode {
  const start = flow.items.find((item) => item.kind === "start");
  const first = flow.edges.find((edge) => edge.source === start?.id)?.target;
  const stand = flow.items.filter((item) => open === null || item.kind === "node");
  const place = new Map(readingOrder(stand.map((item) => item.id), flow.edges, start?.id ?? first).map((id, i) => [id, i]));
  const items = [...stand].sort((a, b) => (place.get(a.id) as number) - (place.get(b.id) as number));
  const ports = new Map(flow.items.flatMap((item) => item.ports.map((port, i) => [portId(item.id, port.outcome), i])));
  const at = (edge: FlowEdge): number => (place.get(edge.source) ?? -1) * 1000 + (ports.get(portId(edge.source, edge.outcome)) ?? 0);
  const edges = [...flow.edges].sort((a, b) => at(a) - at(b)).map((edge) => edgeOf(edge, flow, place, open !== null));
  const children = items.map((item) => boxOf(item, inside.get(item.id)));
  const options = { ...(items.length > MANY ? QUICK : OPTIONS), ...placement };
  if (open === null) return { id: "#root", layoutOptions: { ...options, "elk.padding": "[top=8,left=8,bottom=8,right=8]" }, children, edges };
  const free = Math.max(0, ...open.ports.filter((port) => !port.led).map((port) => textWidth(port.outcome, 12) + 24));
  const east = open.ports.map((port, i): ElkPort => ({ id: portId(BORDER, port.outcome), width: 0, height: 0, layoutOptions: side("EAST", i) }));
  const west: ElkPort = { id: portId(BORDER, ""), width: 0, height: 0, layoutOptions: side("WEST", east.length) };
  const layoutOptions = {
    ...options,
    "elk.padding": `[top=${OPEN_TOP},left=26,bottom=18,right=${22 + free}]`,
    "elk.portConstraints": "FIXED_ORDER",
    "elk.nodeSize.constraints": "[MINIMUM_SIZE]",
    "elk.nodeSize.minimum": `(${open.width},${OPEN_TOP + Math.max(1, open.ports.length) * PORT_HEIGHT})`,
    "elk.spacing.portPort": String(PORT_HEIGHT),
  };
  // ELK takes ports only of a node that stands in another.
  return { id: "#root", layoutOptions: { "elk.algorithm": "layered", "elk.hierarchyHandling": "SEPARATE_CHILDREN" }, children: [{ id: BORDER, layoutOptions, ports: [...east, west], children, edges }] };
}

const side = (name: "EAST" | "WEST", index: number): Record<string, string> => ({ "elk.port.side": name, "elk.port.index": String(index) });

function boxOf(item: FlowItem, level: Level | undefined): ElkNode {
  const { id } = item;
  const { width, height } = level ?? item;
  const node: ElkNode = { id, width, height, layoutOptions: { "elk.portConstraints": "FIXED_POS" } };
  const layer = { start: "FIRST", end: "LAST", node: "" }[item.kind];
  if (layer) node.layoutOptions = { ...node.layoutOptions, "elk.layered.layering.layerConstraint": layer };
  const lead = item.kind === "node" ? (level?.ports.get("")?.y ?? LEAD) : height / 2;
  const port = (outcome: string, name: "EAST" | "WEST", y: number, index: number): ElkPort => ({ id: portId(id, outcome), width: 0, height: 0, x: name === "WEST" ? 0 : width, y, layoutOptions: side(name, index) });
  if (item.kind === "start") return { ...node, ports: [port("", "EAST", lead, 0)] };
  // Clockwise from the north: east from above, then west.
  const east = item.ports.map(({ outcome }, i) => port(outcome, "EAST", level?.ports.get(outcome)?.y ?? LEAD + i * PORT_HEIGHT, i));
  return { ...node, ports: [...east, port("", "WEST", lead, east.length)] };
}

function edgeOf(edge: FlowEdge, flow: Flow, place: ReadonlyMap<string, number>, open: boolean): ElkExtendedEdge {
  const end = open ? flow.items.find((item) => item.id === edge.target && item.kind === "end") : undefined;
  const begin = open && !place.has(edge.source);
  // Only success that goes ahead pulls: it becomes the straight line along which the chart is read. What leaves an open container pulls less.
  const ahead = edge.meaning !== "failure" && (place.get(edge.source) ?? -1) < (place.get(edge.target) ?? Infinity);
  const weight = ahead ? (end ? "10" : "20") : "1";
  const text = edge.label;
  return {
    id: edge.id,
    sources: [begin ? portId(BORDER, "") : portId(edge.source, edge.outcome)],
    targets: [end ? portId(BORDER, end.outcome ?? "") : portId(edge.target, "")],
    layoutOptions: { "elk.layered.priority.straightness": weight, "elk.layered.priority.shortness": weight, "elk.layered.priority.direction": ahead ? "10" : "0" },
    ...(text ? { labels: [{ id: `${edge.id}\nlabel`, text, width: labelWidth(text), height: LABEL_HEIGHT, layoutOptions: { "elk.edgeLabels.placement": "TAIL" } }] } : {}),
  };
}

const whole = ({ x = 0, y = 0 }: { x?: number; y?: number }): Point => ({ x: Math.round(x), y: Math.round(y) });

/**
 * The middle of an edge's words. ELK keeps room for them below their line, at its beginning: on the line they need no more
 * of it. Those of a loop it puts beside one of its pieces; where there are several, they stay there.
 */
function middleOf({ x = 0, y = 0, width = 0, height = 0 }: ElkLabel, points: readonly Point[], where: "tail" | "loop" | "beside"): Point {
  const beside = { x: x + width / 2, y: y + height / 2 };
  if (where === "beside") return whole(beside);
  if (where === "tail") return whole({ x: beside.x + 3, y: points[0]?.y ?? beside.y });
  const level = points.slice(1).filter((point, i) => point.y === points[i]?.y).sort((a, b) => Math.abs(a.y - beside.y) - Math.abs(b.y - beside.y));
  return whole({ ...beside, y: level[0]?.y ?? beside.y });
}

/** What ELK has answered. */
export function levelOf(root: ElkNode): Level {
  const answer = root.children?.find((child) => child.id === BORDER) ?? root;
  const boxes = new Map<string, Box>();
  for (const child of answer.children ?? []) boxes.set(child.id, { ...whole(child), width: child.width ?? 0, height: child.height ?? 0 });
  const lines = new Map<string, Line>();
  const node = (port: string | undefined): string | undefined => port?.split("\n")[0];
  const loops = new Map((answer.edges ?? []).filter((edge) => node(edge.sources[0]) === node(edge.targets[0])).map((edge) => [edge.id, node(edge.sources[0])]));
  const single = (id: string): boolean => [...loops.values()].filter((looped) => looped === loops.get(id)).length === 1;
  for (const edge of (answer.edges ?? []) as ElkExtendedEdge[]) {
    const points = (edge.sections ?? []).flatMap((section) => [section.startPoint, ...(section.bendPoints ?? []), section.endPoint]).map(whole);
    const label = edge.labels?.[0];
    lines.set(edge.id, { points, label: label && points[0] ? middleOf(label, points, !loops.has(edge.id) ? "tail" : single(edge.id) ? "loop" : "beside") : null });
  }
  const ports = new Map((answer.ports ?? []).map((port) => [port.id.slice(BORDER.length + 1), whole(port)]));
  // The outcomes stand where the inside ends; the width may be one from before.
  const width = Math.max(Math.ceil(answer.width ?? 0), ...[...ports.values()].map((port) => port.x));
  return { boxes, lines, ports, width, height: Math.ceil(answer.height ?? 0) };
}

/** Lanes between rows and columns: edges to one target share one. */
const LANES = 6;
const LANE = 8;
const LANES_WIDE = (LANES + 1) * LANE;

export function gridOf(flow: Flow, inside: ReadonlyMap<string, Level>, open: FlowItem | null): Level {
  const start = flow.items.find((item) => item.kind === "start");
  const items = new Map(flow.items.filter((item) => open === null || item.kind === "node").map((item) => [item.id, item]));
  const order = readingOrder([...items.keys()], flow.edges, start?.id);
  const words = Math.max(0, ...flow.edges.map((edge) => (edge.label ? labelWidth(edge.label) : 0)));
  const columns = Math.max(4, Math.ceil(Math.sqrt(order.length * 1.2)));
  const size = (id: string): { width: number; height: number } => inside.get(id) ?? (items.get(id) as FlowItem);
  const wide = Array.from({ length: columns }, (_, c) => Math.max(0, ...order.filter((_, i) => i % columns === c).map((id) => size(id).width)));
  const boxes = new Map<string, Box>();
  /** Below the boxes of each row: where its lanes begin. */
  const lows: number[] = [];
  let y = OPEN_TOP;
  for (let row = 0; row * columns < order.length; row++) {
    const here = order.slice(row * columns, (row + 1) * columns);
    let x = LANES_WIDE + 8;
    here.forEach((id, c) => {
      boxes.set(id, { x, y, ...pick(size(id)) });
      x += (wide[c] as number) + words + 12 + LANES_WIDE;
    });
    lows.push(y + Math.max(...here.map((id) => size(id).height)));
    y = (lows.at(-1) as number) + LANES_WIDE + 12;
  }
  const width = Math.max(0, ...[...boxes.values()].map((box) => box.x + box.width)) + words + LANES_WIDE + 40;
  const ports = new Map<string, Point>([["", { x: 0, y: OPEN_TOP + LEAD }]]);
  open?.ports.forEach((port, i) => ports.set(port.outcome, { x: width, y: OPEN_TOP + LEAD + i * PORT_HEIGHT }));
  const level = { boxes, ports, width, height: y };
  const targets = new Map(flow.items.map((item, i) => [item.id, i % LANES]));
  const lines = new Map<string, Line>();
  const known = new Map(flow.items.map((item) => [item.id, item]));
  const rank = new Map(order.map((id, i) => [id, i]));
  for (const edge of flow.edges) {
    const [from, to] = [known.get(edge.source), known.get(edge.target)] as [FlowItem, FlowItem];
    const at = rank.get(edge.source) ?? -1;
    const [source, target] = [boxes.get(edge.source), boxes.get(edge.target)];
    const a = source === undefined ? (ports.get("") as Point) : leaves(from, edge.outcome, source, inside.get(edge.source));
    const b = target === undefined ? (ports.get(to.outcome ?? "") as Point) : { x: target.x, y: target.y + (to.kind === "end" ? target.height / 2 : (inside.get(edge.target)?.ports.get("")?.y ?? LEAD)) };
    const lane = ((targets.get(edge.target) as number) + 1) * LANE;
    const out = source === undefined ? a.x + lane : source.x + (wide[at % columns] as number) + words + 8 + lane;
    const low = source === undefined ? OPEN_TOP - 4 : (lows[Math.floor(at / columns)] as number) + lane;
    const into = b.x - LANES_WIDE + lane - 4;
    const next = source !== undefined && target !== undefined && rank.get(edge.target) === at + 1 && target.x > source.x;
    const points = next ? [a, { x: into, y: a.y }, { x: into, y: b.y }, b] : [a, { x: out, y: a.y }, { x: out, y: low }, { x: into, y: low }, { x: into, y: b.y }, b];
    lines.set(edge.id, { points: tidied(points), label: edge.label ? { x: a.x + 6 + labelWidth(edge.label) / 2, y: a.y } : null });
  }
  return { ...level, lines };
}

const pick = ({ width, height }: { width: number; height: number }): { width: number; height: number } => ({ width, height });

function leaves(item: FlowItem, outcome: string, box: Box, level: Level | undefined): Point {
  if (item.kind === "start") return { x: box.x + box.width, y: box.y + box.height / 2 };
  const i = Math.max(0, item.ports.findIndex((port) => port.outcome === outcome));
  return { x: box.x + box.width, y: box.y + (level?.ports.get(outcome)?.y ?? LEAD + i * PORT_HEIGHT) };
}
