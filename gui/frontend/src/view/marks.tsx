/** Small marks on nodes: what is wrong with them, and what they do with the variable that the lens is on; and what panes have. */
import type { JSX, PointerEvent } from "react";

import { expressionNames } from "../model/values";
import type { NodeView } from "../protocol/generated";
import { type Pane, usePanes } from "../store/panes";
import { useRun } from "../store/run";
import { breakpointsOf, useRunning } from "../store/runDesk";

/** A breakpoint of the node, and whether the run holds there. */
export function HoldMark({ path }: { path: string }): JSX.Element | null {
  const task = useRun((s) => s.task.path);
  const point = useRunning((s) => breakpointsOf(s.desk, task).find((each) => each.node === path));
  const held = useRun((s) => s.session?.task === s.task.path && s.session.held?.path === path);
  if (!point && !held) return null;
  const words = [held && "the run holds here", point && `breakpoint ${point.when}${point.outcome ? ` ${point.outcome}` : ""}${point.condition ? ` if ${point.condition}` : ""}`].filter(Boolean).join("; ");
  return (
    <span className={`hold-mark${held ? " held" : ""}`} title={words}>
      <span aria-hidden="true">{held ? "▶" : "●"}</span>
      <span className="hidden">{words},</span>
    </span>
  );
}

export function ProblemMark({ path }: { path: string }): JSX.Element | null {
  const worst = useRun((s) => s.index.worst.get(path));
  if (!worst) return null;
  return (
    <span className={`problem-mark ${worst}`} title={worst === "error" ? "has an error" : "has a warning"}>
      <span aria-hidden="true">{worst === "error" ? "✗" : "!"}</span>
      <span className="hidden">{worst},</span>
    </span>
  );
}

export function lensMark(node: NodeView, lens: string | null): JSX.Element | null {
  if (lens === null) return null;
  const { index } = useRun.getState();
  const isIt = (name: string): boolean => index.variable(node.path, name) === lens;
  const writes = Object.values(node.outputs).some(isIt);
  const reads = Object.values(node.inputs).some(isIt) || expressionNames(node).some(isIt);
  if (!writes && !reads) return null;
  return <span className="lens-mark">{[writes && "writes", reads && "reads"].filter(Boolean).join(", ")}</span>;
}

export function NewPane({ task, at, words }: { task: string; at: string; words: string }): JSX.Element {
  return (
    <a className="new-pane" href={`/?${new URLSearchParams({ task, at })}`} target="_blank" rel="noopener" title={words}>
      <svg className="icon" viewBox="0 0 16 16" aria-hidden="true">
        <path d="M6 3H2.5v10.5H13V10M9 2.5h4.5V7M13 3 7.5 8.5" />
      </svg>
      <span className="hidden">{words}</span>
    </a>
  );
}

interface DividerProps {
  readonly pane: Pane;
  readonly across: "x" | "y";
  /** Whether a pane grows when its border is moved right or down; 1 or -1. */
  readonly grows: 1 | -1;
  /** Whether its size is a part of what it stands in, and not pixels. */
  readonly part?: boolean;
}

/** The border between two panes: dragged, or pressed twice to put a pane away. Keys have commands for the same. */
export function Divider({ pane, across, grows, part = false }: DividerProps): JSX.Element {
  function onPointerDown(down: PointerEvent<HTMLElement>): void {
    const { sizes, resize } = usePanes.getState();
    const box = down.currentTarget;
    const around = box.parentElement?.getBoundingClientRect();
    const whole = part ? ((across === "x" ? around?.width : around?.height) ?? 1) / 100 : 1;
    const at = (event: { clientX: number; clientY: number }): number => (across === "x" ? event.clientX : event.clientY);
    const [begin, size] = [at(down), sizes[pane]];
    const onMove = (move: globalThis.PointerEvent): void => resize(pane, size + (grows * (at(move) - begin)) / whole);
    const onUp = (): void => {
      box.removeEventListener("pointermove", onMove);
      box.removeEventListener("pointerup", onUp);
      box.removeEventListener("lostpointercapture", onUp);
    };
    box.setPointerCapture(down.pointerId);
    box.addEventListener("pointermove", onMove);
    box.addEventListener("pointerup", onUp);
    box.addEventListener("lostpointercapture", onUp);
    down.preventDefault();
  }
  return <div className={`divider divider-${across} divider-${pane}`} aria-hidden="true" title="Drag to make room; press twice to put away" onPointerDown={onPointerDown} onDoubleClick={() => part || usePanes.getState().toggle(pane)} />;
}
