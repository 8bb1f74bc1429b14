/** The chart of one container as a graph for ELK's layered layout, and its answer as boxes and lines. */
import type { ElkExtendedEdge, ElkLabel, ElkNode, ElkPort } from "elkjs/lib/elk-api";
import { type Flow, FLOW_HEAD, type FlowEdge, type FlowItem, LEAD, PORT_HEIGHT, rank, readingOrder, textWidth } from "./flow";
import type { Box, Point } from "./layout";

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
export const labelWidth = (text: string): number => textWidth(text, 11) + 14;
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
  "elk.layered.spacing.nodeNodeBetweenLayers": "24",
  "elk.layered.spacing.edgeNodeBetweenLayers": "12",
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
  // In no order of our own, where that stands in the way of a straight line.
  { "elk.layered.considerModelOrder.strategy": "NONE" },
];
const portId = (id: string, outcome: string): string => `${id}\n${outcome}`;
/** The container itself, whose border has the ends of what is inside. */
const BORDER = "#border";

/** What stands in a graph, and where edges to and from what doesn't are on its border: there they have names of their own. */
interface Frame {
  has(item: FlowItem): boolean;
  /** Where on the right an edge leaves it, */
  out(edge: FlowEdge): string;
  /** where on the left one comes in, */
  into(edge: FlowEdge): string;
  /** and the id of its line from there: edges to one target may share it. */
  line(edge: FlowEdge): string;
  readonly layoutOptions: Record<string, string>;
  readonly ports: readonly ElkPort[];
}

/**
 * The graph of a container.
 * @param inside levels of the containers that are open in it.
 * @param open the container's own box, where it is open in another chart: its ends and its start are ports on its border.
 * @param row of a chart that is laid out in rows, what stands in this one: what it leads to elsewhere, and what leads to it
 *   from there, is on its border by the id of the target.
 */
export function graphOf(flow: Flow, inside: ReadonlyMap<string, Level>, open: FlowItem | null, placement: Record<string, string> = {}, row?: ReadonlySet<string>): ElkNode {
  const start = flow.items.find((item) => item.kind === "start");
  const first = flow.edges.find((edge) => edge.source === start?.id)?.target;
  const frame = row ? rowFrame(flow, row) : open ? openFrame(open, new Map(flow.items.map((item) => [item.id, item.outcome ?? ""]))) : null;
  const stand = flow.items.filter((item) => open === null || item.kind === "node");
  const place = new Map(readingOrder(stand.map((item) => item.id), flow.edges, start?.id ?? first).map((id, i) => [id, i]));
  const items = stand.filter((item) => frame?.has(item) ?? true).sort((a, b) => (place.get(a.id) as number) - (place.get(b.id) as number));
  const here = new Set(items.map((item) => item.id));
  const ports = new Map(flow.items.flatMap((item) => item.ports.map((port, i) => [portId(item.id, port.outcome), i])));
  const at = (edge: FlowEdge): number => (place.get(edge.source) ?? -1) * 1000 + (ports.get(portId(edge.source, edge.outcome)) ?? 0);
  const sorted = [...flow.edges].sort((a, b) => at(a) - at(b));
  // Of the edges that come in for one target, that of success says how straight their line is.
  const lines = new Set<string>();
  const isNew = (edge: FlowEdge): boolean => lines.size < lines.add((frame as Frame).line(edge)).size;
  const come = sorted.filter((edge) => !here.has(edge.source) && here.has(edge.target)).sort((a, b) => rank(a.meaning) - rank(b.meaning)).filter(isNew);
  const edges = [...come, ...sorted.filter((edge) => here.has(edge.source))].map((edge) => edgeOf(edge, place, here, frame));
  const children = items.map((item) => boxOf(item, inside.get(item.id)));
  const options = { ...(items.length > MANY ? QUICK : OPTIONS), ...placement };
  if (frame === null) return { id: "#root", layoutOptions: { ...options, "elk.padding": "[top=8,left=8,bottom=8,right=8]" }, children, edges };
  // ELK takes ports only of a node that stands in another.
  const border = { id: BORDER, layoutOptions: { ...options, ...frame.layoutOptions }, ports: [...frame.ports], children, edges };
  return { id: "#root", layoutOptions: { "elk.algorithm": "layered", "elk.hierarchyHandling": "SEPARATE_CHILDREN" }, children: [border] };
}

const onBorder = (name: string, where: "EAST" | "WEST", index: number): ElkPort => ({ id: portId(BORDER, name), width: 0, height: 0, layoutOptions: side(where, index) });
/** Room for the outcomes that lead nowhere: their names are in the box. */
export const freeRoom = (open: FlowItem): number => Math.max(0, ...open.ports.filter((port) => !port.led).map((port) => textWidth(port.outcome, 12) + 24));

function openFrame(open: FlowItem, outcomes: ReadonlyMap<string, string>): Frame {
  const east = open.ports.map((port, i) => onBorder(port.outcome, "EAST", i));
  return {
    has: (item) => item.kind === "node",
    out: (edge) => outcomes.get(edge.target) ?? "",
    into: () => "",
    line: (edge) => edge.id,
    ports: [...east, onBorder("", "WEST", east.length)],
    layoutOptions: {
      "elk.padding": `[top=${OPEN_TOP},left=26,bottom=18,right=${22 + freeRoom(open)}]`,
      "elk.portConstraints": "FIXED_ORDER",
      "elk.nodeSize.constraints": "[MINIMUM_SIZE]",
      "elk.nodeSize.minimum": `(${open.width},${OPEN_TOP + Math.max(1, open.ports.length) * PORT_HEIGHT})`,
      "elk.spacing.portPort": String(PORT_HEIGHT),
    },
  };
}

/** Names on a row's border: where it is left for a target, and where it is entered for one. */
export const leftFor = (target: string): string => `>${target}`;
export const enteredFor = (target: string): string => `<${target}`;

function rowFrame(flow: Flow, row: ReadonlySet<string>): Frame {
  const targets = (from: boolean): string[] => [...new Set(flow.edges.filter((edge) => row.has(edge.source) === from && row.has(edge.target) !== from).map((edge) => edge.target))];
  const east = targets(true).map((target, i) => onBorder(leftFor(target), "EAST", i));
  const west = targets(false).map((target, i) => onBorder(enteredFor(target), "WEST", east.length + i));
  return {
    has: (item) => row.has(item.id),
    out: (edge) => leftFor(edge.target),
    into: (edge) => enteredFor(edge.target),
    line: (edge) => enteredFor(edge.target),
    ports: [...east, ...west],
    layoutOptions: { "elk.padding": "[top=0,left=0,bottom=0,right=6]", "elk.portConstraints": "FIXED_SIDE", "elk.spacing.portPort": "12" },
  };
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

/** @param here what stands in the graph; an edge that comes into it from elsewhere has its words there. */
function edgeOf(edge: FlowEdge, place: ReadonlyMap<string, number>, here: ReadonlySet<string>, frame: Frame | null): ElkExtendedEdge {
  const [begins, ends] = [here.has(edge.source), here.has(edge.target)];
  // Only success that goes ahead pulls: it becomes the straight line along which the chart is read. What leaves an open container pulls less.
  const ahead = edge.meaning !== "failure" && (place.get(edge.source) ?? -1) < (place.get(edge.target) ?? Infinity);
  const weight = ahead ? (ends ? "20" : "10") : "1";
  const text = begins || frame === null ? edge.label : "";
  return {
    id: begins ? edge.id : (frame as Frame).line(edge),
    sources: [begins ? portId(edge.source, edge.outcome) : portId(BORDER, (frame as Frame).into(edge))],
    targets: [ends ? portId(edge.target, "") : portId(BORDER, (frame as Frame).out(edge))],
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
