/** Detail by zoom: from afar only kinds and names, near everything. Sizes stay, so that nothing moves. */
import { useStore } from "@xyflow/react";
import { useEffect } from "react";

const FAR = 0.45;

export function Detail(): null {
  const far = useStore((s) => s.transform[2] < FAR);
  const root = useStore((s) => s.domNode);
  useEffect(() => {
    root?.classList.toggle("far", far);
  }, [root, far]);
  return null;
}
