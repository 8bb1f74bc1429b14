/** Dragging: a palette entry or selected nodes onto a node, before it, after it, or into it. */
import type { DragEvent } from "react";

import { parentOf, type Spot, takesChildren } from "../../model/commands";
import { add, dropAt } from "../../store/gestures";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";

const NEW = "application/x-grip-new";
const NODES = "application/x-grip-nodes";

export function dragNew(event: DragEvent, what: string): void {
  event.dataTransfer.setData(NEW, what);
  event.dataTransfer.effectAllowed = "copy";
}

export function dragNodes(event: DragEvent, path: string): void {
  const { marked, select } = usePage.getState();
  if (!marked.has(path)) select(path);
  event.dataTransfer.setData(NODES, JSON.stringify([...usePage.getState().marked]));
  event.dataTransfer.effectAllowed = "move";
  event.stopPropagation();
}

export function isDrag(event: DragEvent): boolean {
  return event.dataTransfer.types.includes(NEW) || event.dataTransfer.types.includes(NODES);
}

export type Where = "before" | "into" | "after";

/** Which part of a box the pointer is over: its edges mean a place among the siblings, its middle the inside. */
export function whereOver(event: DragEvent, path: string): Where {
  const box = event.currentTarget.getBoundingClientRect();
  const part = (event.clientY - box.top) / box.height;
  const node = useRun.getState().index.byPath.get(path);
  if (path === "/") return "into";
  if (!takesChildren(node)) return part < 0.5 ? "before" : "after";
  return part < 0.28 ? "before" : part > 0.72 ? "after" : "into";
}

function spotAt(path: string, where: Where): Spot | null {
  const nodes = useRun.getState().index.byPath;
  if (where === "into") return { parent: path, index: nodes.get(path)?.children.length ?? 0 };
  const parent = parentOf(path);
  const siblings = parent === null ? undefined : nodes.get(parent);
  if (parent === null || !takesChildren(siblings)) return null;
  return { parent, index: (siblings?.children.indexOf(path) ?? 0) + (where === "after" ? 1 : 0) };
}

export function drop(event: DragEvent, spot: Spot | null): void {
  event.preventDefault();
  event.stopPropagation();
  const what = event.dataTransfer.getData(NEW);
  const moved = event.dataTransfer.getData(NODES);
  if (spot === null) useRun.getState().setTrouble("There is no room here: this container has one child. Wrap the child in a sequence first.");
  else if (what) void add(what, spot);
  else if (moved) void dropAt(JSON.parse(moved) as string[], spot);
}

export function dropOn(event: DragEvent, path: string): void {
  drop(event, spotAt(path, whereOver(event, path)));
}
