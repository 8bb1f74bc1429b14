/** Detail by zoom: from afar only kinds and names, near everything. Sizes stay, so that nothing moves. */
import { type ReactFlowState, useStore } from "@xyflow/react";
import { useEffect } from "react";

const FAR = 0.45;
const NEAR = 1.5;

/** Whether nodes show what they are set to. */
export function isNear(s: ReactFlowState): boolean {
  return s.transform[2] >= NEAR;
}

export function Detail(): null {
  const far = useStore((s) => s.transform[2] < FAR);
  const root = useStore((s) => s.domNode);
  useEffect(() => {
    root?.classList.toggle("far", far);
  }, [root, far]);
  return null;
}
