/** Makes a box on the canvas, or a row of the outline, something that is dragged and dropped on. */
import type { DragEvent } from "react";

import { useRun } from "../store/run";
import { dragNodes, dropOn, isDrag, whereOver } from "./edit/dragging";

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
