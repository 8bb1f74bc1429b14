/** A document after a change that the server sent: only what is different is new, the rest are the objects that were there. */
import type { DocumentChange, DocumentView, NodeView, Problem, TaskChange, TaskView, TextSplice } from "../protocol/generated";

export function changed(document: DocumentView, change: DocumentChange): DocumentView {
  const { state, revision, saved, history, layout, task, splice } = change;
  return {
    ...document,
    state,
    revision,
    saved,
    history,
    change: change.change,
    draft: false,
    checked: false,
    text: splice === null ? document.text : spliced(document.text, splice),
    layout: layout ?? document.layout,
    task: task === null ? document.task : changedTask(document.task, task),
  };
}

function spliced(text: string, { start, removed, new: put }: TextSplice): string {
  return text.slice(0, start) + put + text.slice(start + removed);
}

function changedTask(task: TaskView, { name, doc, outcomes, nodes, gone, variables }: TaskChange): TaskView {
  const byPath = new Map(task.nodes.map((node) => [node.path, node]));
  for (const path of gone) byPath.delete(path);
  for (const node of nodes) byPath.set(node.path, node);
  return { ...task, name, doc, outcomes, nodes: inOrder(byPath), variables: variables ?? task.variables, problems: stillThere(task.problems, byPath) };
}

/** Parents first, in the order of the document. */
function inOrder(byPath: ReadonlyMap<string, NodeView>): NodeView[] {
  const order: NodeView[] = [];
  const open = ["/"];
  for (let path = open.pop(); path !== undefined; path = open.pop()) {
    const node = byPath.get(path);
    if (node === undefined) continue;
    order.push(node);
    for (let i = node.children.length - 1; i >= 0; i--) open.push(node.children[i] as string);
  }
  return order;
}

/** Problems of a state before, until the new ones are known: those of nodes that are gone are gone. */
function stillThere(problems: readonly Problem[], byPath: ReadonlyMap<string, NodeView>): Problem[] {
  return problems.filter(({ path }) => path === "" || byPath.has(path));
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
