/** A document after an edit: what is the same as before is the object that was there, so that it isn't drawn again. */
import type { TaskView } from "../protocol/generated";

/** @param checked whether its problems are known; until they are, those of before are shown, of nodes that are still there. */
export function sharing(task: TaskView, before: TaskView, checked: boolean): TaskView {
  const known = new Map(before.nodes.map((node) => [node.path, node]));
  const nodes = task.nodes.map((node) => {
    const old = known.get(node.path);
    return old !== undefined && JSON.stringify(old) === JSON.stringify(node) ? old : node;
  });
  const there = new Set(task.nodes.map((node) => node.path));
  const problems = checked ? task.problems : before.problems.filter(({ path }) => path === "" || there.has(path));
  const now = { ...task, nodes, problems };
  const rest = (view: TaskView): string => JSON.stringify({ ...view, nodes: [] });
  const same = nodes.length === before.nodes.length && nodes.every((node, i) => node === before.nodes[i]) && rest(now) === rest(before);
  return same ? before : now;
}

/** Where a node is after a change: what is below one that was moved has moved with it. */
export function whereNow(path: string, known: ReadonlyMap<string, unknown>, moved: Readonly<Record<string, string>>): string {
  if (known.has(path)) return path;
  for (let above: string | null = path, below = ""; above !== null; below = path.slice((above ?? "").length)) {
    const to = moved[above];
    const now = to === undefined ? undefined : to === "/" && below !== "" ? below.slice(1) : to + below;
    if (now !== undefined && known.has(now)) return now;
    above = above.includes("/") ? above.slice(0, above.lastIndexOf("/")) : null;
  }
  return path;
}
