/** What of a large drawing is in sight: the boxes and lines that touch a part of it. */
import type { NodeView } from "../protocol/generated";
import type { Box, Point } from "./layout";

export interface Area {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

/** Height below the top of a node at which lines leave and arrive [px]. */
export const LINE_AT = 25;

/** Below this zoom nodes show their names only, in large letters: smaller print can't be read. */
export const FAR = 0.62;

/**
 * The part of the drawing that a pane shows, in whole tiles, so that it changes seldom while the drawing is moved. Near,
 * where elements are many to a tile and each costs something in every step, tiles are smaller.
 * @param moving whether it is dragged: then few elements are there.
 */
export function areaInSight([x, y, zoom]: readonly [number, number, number], width: number, height: number, moving = false): Area {
  const tile = Math.max(width, height, 400) / (zoom < FAR || moving ? 2 : 5) / zoom;
  const floor = (at: number): number => Math.floor(at / tile) * tile;
  const ceil = (at: number): number => Math.ceil(at / tile) * tile;
  return { left: floor(-x / zoom), top: floor(-y / zoom), right: ceil((width - x) / zoom), bottom: ceil((height - y) / zoom) };
}

/** More boxes than these are never elements of the page all at once, where they are too small to be read. */
export const MANY = 80;
/** More than these neither, where not even their names can be read. */
export const FEW = 30;

/** What touches an area, in the order of the boxes. */
export function idsIn(area: Area, boxes: ReadonlyMap<string, Box>): ReadonlySet<string> {
  const found = new Set<string>();
  for (const [id, box] of boxes) if (box.x < area.right && box.x + box.width > area.left && box.y < area.bottom && box.y + box.height > area.top) found.add(id);
  return found;
}

/** Whether a line of these points comes into an area. */
export function touches(points: readonly Point[], area: Area): boolean {
  return points.some((to, i) => {
    const from = points[i - 1] ?? to;
    return Math.min(from.x, to.x) < area.right && Math.max(from.x, to.x) > area.left && Math.min(from.y, to.y) < area.bottom && Math.max(from.y, to.y) > area.top;
  });
}

/** With more children than these a parent has a trunk, on which they hang: as many curves are a grey area, which nobody follows. */
const TRUNK = 24;

/** The lines from parents to children that touch an area, as one SVG path. */
export function linesIn(area: Area, nodes: readonly NodeView[], boxes: ReadonlyMap<string, Box>): string {
  const parts: string[] = [];
  const trunks = new Map<string, { x: number; top: number; bottom: number }>();
  for (const node of nodes) {
    const to = boxes.get(node.path);
    if (to === undefined) continue;
    if (node.children.length > TRUNK) trunks.set(node.path, { x: 0, top: to.y + LINE_AT, bottom: to.y + LINE_AT });
    const from = node.parent === null ? undefined : boxes.get(node.parent);
    if (from === undefined) continue;
    const x1 = from.x + from.width;
    const y1 = from.y + LINE_AT;
    const y2 = to.y + LINE_AT;
    const middle = (x1 + to.x) / 2;
    const trunk = trunks.get(node.parent as string);
    if (trunk) Object.assign(trunk, { x: middle, top: Math.min(trunk.top, y2), bottom: Math.max(trunk.bottom, y2) });
    if (x1 > area.right || to.x < area.left || Math.min(y1, y2) > area.bottom || Math.max(y1, y2) < area.top) continue;
    if (!trunk) parts.push(`M${x1} ${y1}C${middle} ${y1} ${middle} ${y2} ${to.x} ${y2}`);
    else if (y2 >= area.top && y2 <= area.bottom) parts.push(`M${middle} ${y2}H${to.x}`);
  }
  for (const [path, { x, top, bottom }] of trunks) {
    const from = boxes.get(path) as Box;
    const [low, high] = [Math.max(top, area.top), Math.min(bottom, area.bottom)];
    if (top === bottom || low > high || x < area.left || from.x > area.right) continue;
    parts.push(`M${x} ${low}V${high}M${from.x + from.width} ${from.y + LINE_AT}H${x}`);
  }
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

/** Tasks with more nodes are opened folded. */
const LARGE = 1000;
/** So many nodes of such a task are shown at first. */
const FIRST = 200;

/** Containers of a task to fold when it is opened: level by level is opened while there is room. */
export function foldedAtFirst(nodes: readonly NodeView[]): ReadonlySet<string> {
  if (nodes.length <= LARGE) return new Set();
  const folded = new Set<string>();
  const depth = new Map<string, number>();
  const levels: NodeView[][] = [];
  for (const node of nodes) {
    const level = node.parent === null ? 0 : (depth.get(node.parent) ?? 0) + 1;
    depth.set(node.path, level);
    (levels[level] ??= []).push(node);
  }
  let shown = 0;
  levels.forEach((level, at) => {
    shown += level.length;
    const full = shown + (levels[at + 1]?.length ?? 0) > FIRST && at > 0;
    for (const node of level) if (full && node.children.length > 0) folded.add(node.path);
  });
  return folded;
}

/** All containers below the root. */
export function allFolded(nodes: readonly NodeView[]): ReadonlySet<string> {
  return new Set(nodes.filter((node) => node.parent !== null && node.children.length > 0).map((node) => node.path));
}

/** The nodes that aren't inside a folded container, in their order. */
export function unfolded(nodes: readonly NodeView[], closed: ReadonlySet<string>): readonly NodeView[] {
  if (closed.size === 0) return nodes;
  const hidden = new Set<string>();
  return nodes.filter((node) => {
    if (node.parent === null || !(closed.has(node.parent) || hidden.has(node.parent))) return true;
    hidden.add(node.path);
    return false;
  });
}

/** Without the containers around these nodes, so that they can be seen. */
export function opened(closed: ReadonlySet<string>, paths: Iterable<string>): ReadonlySet<string> {
  if (closed.size === 0) return closed;
  const next = new Set(closed);
  for (const path of paths) {
    if (path !== "/") next.delete("/");
    for (let at = path.lastIndexOf("/"); at > 0; at = path.lastIndexOf("/", at - 1)) next.delete(path.slice(0, at));
  }
  return next.size === closed.size ? closed : next;
}

/** The nearest node at or above `path` that is shown. */
export function nearestShown(path: string, shown: { has(path: string): boolean }): string {
  let at = path;
  while (at !== "/" && !shown.has(at)) at = at.includes("/") ? at.slice(0, at.lastIndexOf("/")) : "/";
  return at;
}

export interface Row {
  readonly node: NodeView;
  readonly level: number;
  readonly position: number;
  readonly siblings: number;
}

/** The rows that can be seen: those whose containers are all open. */
export function visibleRows(nodes: readonly NodeView[], closed: ReadonlySet<string>): Row[] {
  const byPath = new Map(nodes.map((node) => [node.path, node]));
  const rows: Row[] = [];
  const root = nodes[0];
  if (!root) return rows;
  const open: Row[] = [{ node: root, level: 1, position: 1, siblings: 1 }];
  for (let row = open.pop(); row; row = open.pop()) {
    rows.push(row);
    if (closed.has(row.node.path)) continue;
    const { children } = row.node;
    for (let i = children.length - 1; i >= 0; i--) {
      const node = byPath.get(children[i] as string);
      if (node) open.push({ node, level: row.level + 1, position: i + 1, siblings: children.length });
    }
  }
  return rows;
}

export type OutlineStep = { readonly go: string } | { readonly open: string } | { readonly close: string } | null;

/** What a key does when the focus is on `path`. */
export function outlineKey(key: string, path: string, rows: readonly Row[], closed: ReadonlySet<string>): OutlineStep {
  const at = rows.findIndex((row) => row.node.path === path);
  const row = rows[at];
  if (!row) return null;
  const go = (target: Row | undefined): OutlineStep => (target ? { go: target.node.path } : null);
  const isOpen = row.node.children.length > 0 && !closed.has(path);
  switch (key) {
    case "ArrowDown":
      return go(rows[at + 1]);
    case "ArrowUp":
      return go(rows[at - 1]);
    case "Home":
      return go(rows[0]);
    case "End":
      return go(rows.at(-1));
    case "ArrowRight":
      if (isOpen) return go(rows[at + 1]);
      return row.node.children.length > 0 ? { open: path } : null;
    case "ArrowLeft":
      if (isOpen) return { close: path };
      return row.node.parent === null ? null : { go: row.node.parent };
    default:
      return null;
  }
}
