/** Where a flow chart's nodes go: layered by a library, except those that a person has pinned, which never move. */
import dagre from "@dagrejs/dagre";

import type { NodeView } from "../protocol/generated";
import { type Flow, type FlowItem, isStart } from "./flow";

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

export const NODE_WIDTH = 232;
export const ROW_HEIGHT = 18;
const HEAD_HEIGHT = 50;
const COLUMN = NODE_WIDTH + 52;
const SIBLING_GAP = 12;

export interface Box {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

export function sizeOf(node: NodeView): { width: number; height: number } {
  const rows = node.on.length;
  return { width: NODE_WIDTH, height: HEAD_HEIGHT + (rows ? rows * ROW_HEIGHT + 6 : 0) };
}

/** How far a subtree reaches up and down in each column, relative to the top of its root. */
interface Contour {
  readonly top: number[];
  readonly bottom: number[];
}

/**
 * Tidy tree from left to right: a column per depth, children in order, a parent in the middle of its children, subtrees
 * pushed together as far as their contours allow (Reingold and Tilford 1981, with sizes).
 */
export function layoutTree(nodes: readonly NodeView[]): Map<string, Box> {
  const byPath = new Map(nodes.map((node) => [node.path, node]));
  const offsets = new Map<string, number>();
  const contours = new Map<string, Contour>();
  // Parents come first in `nodes`, so that backwards every child is finished before its parent.
  for (let i = nodes.length - 1; i >= 0; i--) {
    const node = nodes[i] as NodeView;
    contours.set(node.path, place(node, offsets, contours));
    for (const child of node.children) contours.delete(child);
  }
  return absolute(nodes, byPath, offsets);
}

/** Put a node's children below each other, and return the contour of the whole. */
function place(node: NodeView, offsets: Map<string, number>, contours: Map<string, Contour>): Contour {
  const { height } = sizeOf(node);
  const merged: Contour = { top: [], bottom: [] };
  const tops: number[] = [];
  for (const child of node.children) {
    const contour = contours.get(child);
    if (!contour) continue;
    const y = firstFree(merged, contour);
    tops.push(y);
    offsets.set(child, y);
    for (let d = 0; d < contour.top.length; d++) {
      merged.top[d] = Math.min(merged.top[d] ?? Infinity, y + (contour.top[d] as number));
      merged.bottom[d] = Math.max(merged.bottom[d] ?? -Infinity, y + (contour.bottom[d] as number));
    }
  }
  if (tops.length === 0) return { top: [0], bottom: [height] };
  const middle = ((merged.top[0] as number) + (merged.bottom[0] as number)) / 2;
  const shift = Math.round(height / 2 - middle);
  for (const child of node.children) offsets.set(child, (offsets.get(child) ?? 0) + shift);
  return { top: [0, ...merged.top.map((y) => y + shift)], bottom: [height, ...merged.bottom.map((y) => y + shift)] };
}

function firstFree(above: Contour, contour: Contour): number {
  let y = 0;
  for (let d = 0; d < Math.min(above.bottom.length, contour.top.length); d++) {
    y = Math.max(y, (above.bottom[d] as number) + SIBLING_GAP - (contour.top[d] as number));
  }
  return y;
}

function absolute(
  nodes: readonly NodeView[],
  byPath: ReadonlyMap<string, NodeView>,
  offsets: ReadonlyMap<string, number>,
): Map<string, Box> {
  const boxes = new Map<string, Box>();
  let highest = 0;
  for (const node of nodes) {
    const parent = node.parent !== null && byPath.has(node.parent) ? boxes.get(node.parent) : undefined;
    const x = parent ? parent.x + COLUMN : 0;
    const y = (parent?.y ?? 0) + (offsets.get(node.path) ?? 0);
    boxes.set(node.path, { x, y, ...sizeOf(node) });
    highest = Math.min(highest, y);
  }
  for (const [path, box] of boxes) boxes.set(path, { ...box, y: box.y - highest });
  return boxes;
}
