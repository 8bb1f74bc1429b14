/** Where a flow chart's nodes go: layered by a library, except those that a person has pinned, which never move. */
import dagre from "@dagrejs/dagre";

import { type Flow, type FlowItem, isStart } from "./flow";
import type { Box } from "./layout";

const GAP = 24;
/** Below a node that leads to itself: its edge goes round there. */
export const LOOP_ROOM = 34;
type Pins = Readonly<Record<string, readonly [number, number] | number[]>>;

export interface FlowLayout {
  readonly boxes: ReadonlyMap<string, Box>;
  /** Where an edge bends, between its ends, so that it goes round the nodes; none where nodes were pinned. */
  readonly bends: ReadonlyMap<string, readonly Point[]>;
}

export interface Point {
  readonly x: number;
  readonly y: number;
}

/** Boxes by id. Pinned nodes are where they were put; the others keep their layers and make room. */
export function layoutFlow(flow: Flow, pins: Pins = {}): FlowLayout {
  const layout = layered(flow);
  const pinned = flow.items.filter((item) => pins[item.id] !== undefined);
  return pinned.length === 0 ? layout : { boxes: withPins(flow, pinned, pins, layout.boxes), bends: new Map() };
}

function withPins(flow: Flow, pinned: readonly FlowItem[], pins: Pins, free: ReadonlyMap<string, Box>): Map<string, Box> {
  const boxes = new Map<string, Box>();
  let dx = 0;
  let dy = 0;
  for (const { id, width, height } of pinned) {
    const [x = 0, y = 0] = pins[id] as number[];
    boxes.set(id, { x, y, width, height });
    dx += (x - (free.get(id)?.x ?? 0)) / pinned.length;
    dy += (y - (free.get(id)?.y ?? 0)) / pinned.length;
  }
  const rest = flow.items.filter((item) => !boxes.has(item.id)).map((item) => free.get(item.id) as Box & { id?: string });
  const ids = flow.items.filter((item) => !boxes.has(item.id)).map((item) => item.id);
  ids
    .map((id, i) => ({ id, box: rest[i] as Box }))
    .sort((a, b) => a.box.x - b.box.x || a.box.y - b.box.y)
    .forEach(({ id, box }) => boxes.set(id, makeRoom({ ...box, x: Math.round(box.x + dx), y: Math.round(box.y + dy) }, boxes)));
  return boxes;
}

function layered(flow: Flow): FlowLayout {
  const graph = new dagre.graphlib.Graph({ multigraph: true });
  graph.setGraph({ rankdir: "LR", nodesep: 28, ranksep: 64, marginx: 8, marginy: 8 });
  graph.setDefaultEdgeLabel(() => ({}));
  const looped = new Set(flow.edges.filter((edge) => edge.source === edge.target).map((edge) => edge.source));
  for (const { id, width, height } of flow.items) graph.setNode(id, { width, height: height + (looped.has(id) ? LOOP_ROOM : 0) });
  for (const edge of flow.edges) {
    if (edge.source !== edge.target) graph.setEdge(edge.source, edge.target, { weight: isStart(edge.source) ? 4 : 1 }, edge.id);
  }
  // An end that nothing leads to stands where ends stand, not where it all begins.
  const last = flow.items.filter((item) => item.kind === "node").at(-1)?.id;
  const led = new Set(flow.edges.map((edge) => edge.target));
  for (const item of flow.items) if (item.kind === "end" && !led.has(item.id) && last) graph.setEdge(last, item.id, { weight: 0 }, `#${item.id}`);
  dagre.layout(graph);
  const boxes = new Map<string, Box>();
  for (const { id, width, height } of flow.items) {
    const { x, y } = graph.node(id) as { x: number; y: number };
    const room = looped.has(id) ? LOOP_ROOM : 0;
    boxes.set(id, { x: Math.round(x - width / 2), y: Math.round(y - (height + room) / 2), width, height });
  }
  const bends = new Map<string, readonly Point[]>();
  for (const edge of flow.edges) {
    if (edge.source === edge.target) continue;
    const { points } = graph.edge(edge.source, edge.target, edge.id) as { points: Point[] };
    // The first and the last are on the borders of the boxes, where the ports aren't.
    bends.set(edge.id, points.slice(1, -1));
  }
  return { boxes, bends };
}

/** The box, moved down until it overlaps none of the others. */
function makeRoom(box: Box, others: ReadonlyMap<string, Box>): Box {
  let y = box.y;
  for (let moved = true; moved; ) {
    moved = false;
    for (const other of others.values()) {
      const beside = box.x + box.width + GAP <= other.x || other.x + other.width + GAP <= box.x;
      if (beside || y + box.height + GAP <= other.y || other.y + other.height + GAP <= y) continue;
      y = other.y + other.height + GAP;
      moved = true;
    }
  }
  return { ...box, y };
}
