/** The borders between panes: dragged, or pressed twice to put a pane away. Keys have commands for the same. */
import type { JSX, PointerEvent } from "react";

import { type Pane, usePanes } from "../store/panes";

interface Props {
  readonly pane: Pane;
  readonly across: "x" | "y";
  /** Whether a pane grows when its border is moved right or down; 1 or -1. */
  readonly grows: 1 | -1;
  /** Whether its size is a part of what it stands in, and not pixels. */
  readonly part?: boolean;
}

export function Divider({ pane, across, grows, part = false }: Props): JSX.Element {
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
