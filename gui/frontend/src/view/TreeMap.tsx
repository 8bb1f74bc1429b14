/** A map of the whole tree in a corner: one shape for all nodes, a frame for what is in sight; press or drag to go there. */
import { Panel, useReactFlow, useStore } from "@xyflow/react";
import { type JSX, type PointerEvent, useMemo } from "react";

import type { Box } from "../model/layout";
import { extent, silhouette } from "../model/sight";

const WIDTH = 140;
const HEIGHT = 96;

export function TreeMap({ boxes }: { boxes: ReadonlyMap<string, Box> }): JSX.Element {
  const { setCenter, getZoom } = useReactFlow();
  const all = useMemo(() => extent(boxes.values()), [boxes]);
  const shape = useMemo(() => silhouette(boxes.values()), [boxes]);
  const scale = Math.max((all.right - all.left) / WIDTH, (all.bottom - all.top) / HEIGHT, 1);
  const go = (event: PointerEvent<SVGSVGElement>): void => {
    if (event.buttons !== 1) return;
    const frame = event.currentTarget.getBoundingClientRect();
    const x = (all.left + all.right) / 2 + (event.clientX - frame.left - frame.width / 2) * scale;
    const y = (all.top + all.bottom) / 2 + (event.clientY - frame.top - frame.height / 2) * scale;
    void setCenter(x, y, { zoom: getZoom(), duration: 0 });
  };
  const left = (all.left + all.right - WIDTH * scale) / 2;
  const top = (all.top + all.bottom - HEIGHT * scale) / 2;
  return (
    <Panel position="bottom-right" className="tree-map nopan nowheel">
      <svg
        width={WIDTH}
        height={HEIGHT}
        viewBox={`${left} ${top} ${WIDTH * scale} ${HEIGHT * scale}`}
        aria-hidden="true"
        onPointerDown={(event) => {
          event.currentTarget.setPointerCapture(event.pointerId);
          go(event);
        }}
        onPointerMove={go}
      >
        <path d={shape} />
        <Frame />
      </svg>
    </Panel>
  );
}

/** What is in sight. */
function Frame(): JSX.Element {
  const [x, y, zoom] = useStore((s) => s.transform);
  const width = useStore((s) => s.width);
  const height = useStore((s) => s.height);
  return <rect className="frame" x={-x / zoom} y={-y / zoom} width={width / zoom} height={height / zoom} vectorEffect="non-scaling-stroke" />;
}
