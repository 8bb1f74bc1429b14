/** Where the nodes of a tree stand; boxes and points of every drawing. */
import type { NodeView } from "../protocol/generated";

export interface Point {
  readonly x: number;
  readonly y: number;
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
