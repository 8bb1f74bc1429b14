/** Where a flow chart's nodes go: layered by a library, except those that a person has pinned, which never move. */
import dagre from "@dagrejs/dagre";

import type { Flow } from "./flow";
import type { Box } from "./layout";

const GAP = 24;
type Pins = Readonly<Record<string, readonly [number, number] | number[]>>;

/** Boxes by id. Pinned nodes are where they were put; the others keep their layers and make room. */
export function layoutFlow(flow: Flow, pins: Pins = {}): Map<string, Box> {
  const free = layered(flow);
  const pinned = flow.items.filter((item) => pins[item.id] !== undefined);
  if (pinned.length === 0) return free;
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

function layered(flow: Flow): Map<string, Box> {
  const graph = new dagre.graphlib.Graph({ multigraph: true });
  graph.setGraph({ rankdir: "LR", nodesep: 28, ranksep: 64, marginx: 8, marginy: 8 });
  graph.setDefaultEdgeLabel(() => ({}));
  for (const { id, width, height } of flow.items) graph.setNode(id, { width, height });
  for (const edge of flow.edges) {
    if (edge.source !== edge.target) graph.setEdge(edge.source, edge.target, { weight: edge.source === "#start" ? 4 : 1 }, edge.id);
  }
  dagre.layout(graph);
  const boxes = new Map<string, Box>();
  for (const { id, width, height } of flow.items) {
    const { x, y } = graph.node(id) as { x: number; y: number };
    boxes.set(id, { x: Math.round(x - width / 2), y: Math.round(y - height / 2), width, height });
  }
  return boxes;
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
