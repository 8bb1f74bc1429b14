/** Makes a box on the canvas, or a row of the outline, something that is dragged and dropped on. */
import { type DragEvent, type RefObject, type UIEvent, useEffect, useLayoutEffect, useState, useSyncExternalStore } from "react";

import { server } from "../protocol/client";
import type { StudySpan } from "../protocol/generated";
import { parentOf, type Spot, takesChildren } from "../model/commands";
import { actionFor } from "../store/actions";
import { expecting, isExpected, useAsk } from "../store/ask";
import { editable } from "../store/editing";
import { add, dropAt } from "../store/gestures";
import { usePage } from "../store/page";
import { useRun } from "../store/run";

export interface DropProps {
  readonly draggable: boolean;
  readonly onDragStart: (event: DragEvent) => void;
  readonly onDragOver: (event: DragEvent) => void;
  readonly onDragLeave: (event: DragEvent) => void;
  readonly onDrop: (event: DragEvent) => void;
}

export function useDropTarget(path: string): DropProps {
  const locked = useRun((s) => s.record !== null);
  const clear = (event: DragEvent): void => event.currentTarget.removeAttribute("data-drop");
  return {
    draggable: !locked && path !== "/",
    onDragStart: (event) => dragNodes(event, path),
    onDragOver: (event) => {
      if (locked || !isDrag(event)) return;
      event.preventDefault();
      event.stopPropagation();
      event.currentTarget.setAttribute("data-drop", whereOver(event, path));
    },
    onDragLeave: clear,
    onDrop: (event) => {
      clear(event);
      dropOn(event, path);
    },
  };
}

export const ROW_HEIGHT = 26;
/** Lists up to this length are there as a whole. */
const WHOLE = 200;
/** Rows beyond what is visible, above and below. */
const SPARE = 30;
/** The window moves in steps, so that scrolling renders seldom. */
const STEP = 10;

export interface Window {
  readonly first: number;
  readonly last: number;
  readonly onScroll: (event: UIEvent) => void;
}

/** Which rows of a scrolling box are to be there; the row `at` is brought into sight whenever it changes. */
export function useWindow(box: RefObject<HTMLElement | null>, count: number, at: number): Window {
  const [top, setTop] = useState(0);
  const [height, setHeight] = useState(600);
  useLayoutEffect(() => {
    if (box.current) setHeight(box.current.clientHeight || 600);
  }, [box, count]);
  useEffect(() => {
    const element = box.current;
    if (!element || at < 0) return;
    const above = at * ROW_HEIGHT;
    if (above < element.scrollTop) element.scrollTop = above;
    else if (above + ROW_HEIGHT > element.scrollTop + element.clientHeight) element.scrollTop = above + ROW_HEIGHT - element.clientHeight;
    setTop(Math.floor(element.scrollTop / ROW_HEIGHT / STEP) * STEP);
  }, [box, at, count]);
  const onScroll = (event: UIEvent): void => setTop(Math.floor(event.currentTarget.scrollTop / ROW_HEIGHT / STEP) * STEP);
  if (count <= WHOLE) return { first: 0, last: count, onScroll };
  const first = Math.max(0, Math.min(top, count) - SPARE);
  return { first, last: Math.min(count, top + Math.ceil(height / ROW_HEIGHT) + SPARE + STEP), onScroll };
}

/** Keys that buttons and links need for themselves. */
const PRESSES = new Set(["Enter", " "]);
/** What also works where no task is shown. */
const EVERYWHERE = new Set(["stop", "pause", "panel", "panel-before"]);
const READING = new Set(["robot", "left", "right", "foot", "panes", "commands", "panel", "panel-before", "find", "toggle", "tree", "flow", "split", "text", "enter", "leave", "copy", "new", "run", "pause", "stop", "breakpoint", "over", "into", "step-out", "tick", "fault", "from-here", "to-here"]);

function inField(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.closest("input, textarea, select, [contenteditable=true]") !== null;
}

function onPressable(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.closest("button, a, summary, [role=slider], [role=tab]") !== null;
}

function onKeyDown(event: KeyboardEvent): void {
  if (useAsk.getState().question !== null || event.defaultPrevented) return;
  const action = actionFor(event);
  const isLetter = !event.ctrlKey && !event.metaKey && !event.altKey; // what is typed for a question that is about to come
  if (isLetter && isExpected() && !(action && EVERYWHERE.has(action.id))) return;
  if (!action || (inField(event.target) && !action.inFields)) return;
  if (usePage.getState().room === "project" && !EVERYWHERE.has(action.id)) return;
  if (PRESSES.has(event.key) && onPressable(event.target)) return;
  // Text that a person has marked is what is copied.
  if (action.id === "copy" && !getSelection()?.isCollapsed) return;
  if (!editable() && !READING.has(action.id)) return;
  event.preventDefault();
  void (action.asks ? expecting(action.run) : action.run());
}

export function useKeys(): void {
  useEffect(() => {
    window.addEventListener("keydown", onKeyDown);
    return () => window.removeEventListener("keydown", onKeyDown);
  }, []);
}

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
  if (spot === null) useRun.getState().setError("This container takes one child only. Wrap the child in a sequence first.");
  else if (what) void add(what, spot);
  else if (moved) void dropAt(JSON.parse(moved) as string[], spot);
}

export function dropOn(event: DragEvent, path: string): void {
  drop(event, spotAt(path, whereOver(event, path)));
}

const LOOK = 500;
/** A span is told when it ends, and before it has grown so long [ms]: what a page that is closed hasn't told is lost. */
const SPAN = 5000;

function focus(): StudySpan["window"] {
  if (document.hidden || !document.hasFocus()) return "away";
  const { session, task } = useRun.getState();
  if (usePage.getState().room === "project" || task.path === "") return "configure";
  return session !== null && session.state !== "ended" ? "run" : "program";
}

/** Tell a study how long what has had the focus; without one, nothing is measured. */
export function useStudy(): void {
  useEffect(() => {
    let [what, since] = [focus(), performance.now()];
    const page = Math.random().toString(36).slice(2, 10);
    let timer: ReturnType<typeof setInterval> | undefined;
    const tell = (seconds: number): Promise<void> => server.study({ window: what, seconds, page }).then((wanted) => {
      if (wanted && timer === undefined) timer = setInterval(look, LOOK);
    });
    function look(): void {
      const [now, spent] = [focus(), performance.now() - since];
      if (now === what && spent < SPAN) return;
      void tell(spent / 1000).catch(() => undefined);
      [what, since] = [now, performance.now()];
    }
    void tell(0).catch(() => undefined);
    return () => clearInterval(timer);
  }, []);
}

const DARK = "(prefers-color-scheme: dark)";

function onTheme(changed: () => void): () => void {
  const dark = matchMedia(DARK);
  dark.addEventListener("change", changed);
  return () => dark.removeEventListener("change", changed);
}

/** Whether the theme is dark: what draws on a canvas draws anew when that changes. */
export function useDark(): boolean {
  return useSyncExternalStore(onTheme, () => matchMedia(DARK).matches);
}
