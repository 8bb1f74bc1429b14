/** Activations of leaves over the run's time: the bars of the time line. */
import type { RunEvent } from "../protocol/generated";
import type { Phase, TaskIndex } from "./status";

export interface Span {
  readonly path: string;
  readonly from: number;
  readonly to: number | null;
  readonly phase: Phase;
  readonly lane: number;
}

/** Bars in the order of their start; those that overlap get different lanes. */
export function spansOf(events: readonly RunEvent[], index: TaskIndex): Span[] {
  const spans: Span[] = [];
  const open = new Map<string, number>();
  const lanes: (string | null)[] = [];
  const close = (path: string, to: number, phase: Phase): void => {
    const at = open.get(path);
    if (at === undefined) return;
    const span = spans[at] as Span;
    spans[at] = { ...span, to, phase };
    lanes[span.lane] = null;
    open.delete(path);
  };
  for (const event of events) {
    if (index.byPath.get(event.path)?.kind !== "leaf") continue;
    if (event.event === "enter" || (event.event === "went_on" && !open.has(event.path))) {
      close(event.path, event.t, "ended");
      const free = lanes.indexOf(null);
      const lane = free < 0 ? lanes.length : free;
      lanes[lane] = event.path;
      open.set(event.path, spans.length);
      spans.push({ path: event.path, from: event.t, to: null, phase: "running", lane });
    } else if (event.event === "exit") {
      close(event.path, event.t, index.phaseOf(event.path, event.outcome));
    } else if (event.event === "interrupted" || event.event === "error") {
      close(event.path, event.t, event.event);
    }
  }
  return spans;
}
