/** Containers that are folded: what is inside them is neither laid out nor drawn, and a large task opens with its top alone. */
import type { NodeView } from "../protocol/generated";

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
