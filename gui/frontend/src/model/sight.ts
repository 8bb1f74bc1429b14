/** What of a large drawing is in sight: the boxes and lines that touch a part of it. */
import type { NodeView } from "../protocol/generated";
import type { Box } from "./layout";

export interface Area {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

/** Height below the top of a node at which lines leave and arrive [px]. */
export const LINE_AT = 25;

/** The part of the drawing that a pane shows, in whole tiles, so that it changes seldom while the drawing is moved. */
export function areaInSight([x, y, zoom]: readonly [number, number, number], width: number, height: number): Area {
  const tile = Math.max(width, height, 400) / 2 / zoom;
  const floor = (at: number): number => Math.floor(at / tile) * tile;
  const ceil = (at: number): number => Math.ceil(at / tile) * tile;
  return { left: floor(-x / zoom), top: floor(-y / zoom), right: ceil((width - x) / zoom), bottom: ceil((height - y) / zoom) };
}

export function nodesIn(area: Area, nodes: readonly NodeView[], boxes: ReadonlyMap<string, Box>): NodeView[] {
  return nodes.filter((node) => {
    const box = boxes.get(node.path);
    return box !== undefined && box.x < area.right && box.x + box.width > area.left && box.y < area.bottom && box.y + box.height > area.top;
  });
}

/** The lines from parents to children that touch an area, as one SVG path. */
export function linesIn(area: Area, nodes: readonly NodeView[], boxes: ReadonlyMap<string, Box>): string {
  const parts: string[] = [];
  for (const node of nodes) {
    const to = boxes.get(node.path);
    const from = node.parent === null ? undefined : boxes.get(node.parent);
    if (to === undefined || from === undefined) continue;
    const x1 = from.x + from.width;
    const y1 = from.y + LINE_AT;
    const y2 = to.y + LINE_AT;
    if (x1 > area.right || to.x < area.left || Math.min(y1, y2) > area.bottom || Math.max(y1, y2) < area.top) continue;
    const middle = (x1 + to.x) / 2;
    parts.push(`M${x1} ${y1}C${middle} ${y1} ${middle} ${y2} ${to.x} ${y2}`);
  }
  return parts.join("");
}

/** All boxes as one SVG path, for a map. */
export function silhouette(boxes: Iterable<Box>): string {
  const parts: string[] = [];
  for (const { x, y, width, height } of boxes) parts.push(`M${x} ${y}h${width}v${height}h${-width}z`);
  return parts.join("");
}

export function extent(boxes: Iterable<Box>): Area {
  let [left, top, right, bottom] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const box of boxes) {
    left = Math.min(left, box.x);
    top = Math.min(top, box.y);
    right = Math.max(right, box.x + box.width);
    bottom = Math.max(bottom, box.y + box.height);
  }
  return right < left ? { left: 0, top: 0, right: 0, bottom: 0 } : { left, top, right, bottom };
}

/** More nodes than these have a map in the corner, */
export const FEW_NODES = 12;
/** which hides what is in its corner [px], with what is around it, */
const MAP = { width: 160, height: 116 };
/** and needs a pane of this width [px]: else it would hide most of it. */
const MAP_PANE = 480;

export const hasRoomForMap = (width: number): boolean => width >= MAP_PANE;

/** Whether a box is wholly in a pane, and not below its map. */
export function isInSight(box: Box, { x, y, zoom }: { x: number; y: number; zoom: number }, width: number, height: number, mapped: boolean): boolean {
  const left = box.x * zoom + x;
  const top = box.y * zoom + y;
  const right = left + box.width * zoom;
  const bottom = top + box.height * zoom;
  const hidden = mapped && right > width - MAP.width && bottom > height - MAP.height;
  return left >= 0 && top >= 0 && right <= width && bottom <= height && !hidden;
}
