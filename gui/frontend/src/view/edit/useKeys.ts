/** The keyboard: every action by its keys, wherever the focus is, except where a field needs the key itself. */
import { useEffect } from "react";

import { actionFor } from "../../store/actions";
import { useAsk } from "../../store/ask";
import { editable } from "../../store/editing";
import { usePage } from "../../store/page";

/** Keys that buttons and links need for themselves. */
const PRESSES = new Set(["Enter", " "]);
/** What also works where no task is shown. */
const EVERYWHERE = new Set(["stop", "pause", "panel", "panel-before"]);
const READING = new Set(["commands", "panel", "panel-before", "find", "toggle", "tree", "flow", "split", "text", "enter", "leave", "copy", "new", "run", "pause", "stop", "breakpoint", "over", "into", "step-out", "tick", "from-here", "to-here"]);

function inField(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.closest("input, textarea, select, [contenteditable=true]") !== null;
}

function onPressable(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.closest("button, a, summary, [role=slider], [role=tab]") !== null;
}

function onKeyDown(event: KeyboardEvent): void {
  if (useAsk.getState().question !== null || event.defaultPrevented) return;
  const action = actionFor(event);
  if (!action || (inField(event.target) && !action.inFields)) return;
  if (usePage.getState().room === "project" && !EVERYWHERE.has(action.id)) return;
  if (PRESSES.has(event.key) && onPressable(event.target)) return;
  // Text that a person has marked is what is copied.
  if (action.id === "copy" && !getSelection()?.isCollapsed) return;
  if (!editable() && !READING.has(action.id)) return;
  event.preventDefault();
  void action.run();
}

export function useKeys(): void {
  useEffect(() => {
    window.addEventListener("keydown", onKeyDown);
    return () => window.removeEventListener("keydown", onKeyDown);
  }, []);
}
