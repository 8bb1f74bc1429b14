/** The rows of the outline, and where its keys lead (WAI-ARIA tree pattern). */
import type { NodeView } from "../protocol/generated";

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
