/** An edge that goes round the nodes: through the bends that the layout has found, level where it leaves and arrives. */
import { BaseEdge, EdgeLabelRenderer, type EdgeProps, getBezierPath } from "@xyflow/react";
import type { JSX } from "react";

import type { Point } from "../../model/flowLayout";

export function FlowEdgeLine(props: EdgeProps): JSX.Element {
  const { id, sourceX, sourceY, targetX, targetY, data, label, markerEnd, selected, source, target } = props;
  const bends = (data?.["bends"] ?? []) as readonly Point[];
  const from = { x: sourceX, y: sourceY };
  const to = { x: targetX, y: targetY };
  const loop = source === target;
  const back = targetX < sourceX + 10;
  const points = loop ? around(from, to) : bends.length > 1 || back ? [from, ...bends, to] : [from, to];
  const [path, x, y] = points.length === 2 ? getBezierPath(props) : [smooth(points), ...middle(points)];
  return (
    <>
      <BaseEdge id={id} path={path} interactionWidth={18} {...(markerEnd ? { markerEnd } : {})} />
      {label !== undefined && (
        <EdgeLabelRenderer>
          <span className={`edge-label${selected ? " selected" : ""}`} style={{ transform: `translate(-50%, -50%) translate(${x}px, ${y}px)` }}>
            {label}
          </span>
        </EdgeLabelRenderer>
      )}
    </>
  );
}

/** Round below the node, back to its own entry. */
function around(from: Point, to: Point): Point[] {
  const below = Math.max(from.y, to.y) + 62;
  return [from, { x: from.x + 22, y: (from.y + below) / 2 }, { x: (from.x + to.x) / 2, y: below }, { x: to.x - 22, y: (to.y + below) / 2 }, to];
}

/** A curve through points: each piece leaves and arrives level. */
function smooth(points: readonly Point[]): string {
  const [first, ...rest] = points as [Point, ...Point[]];
  let at = first;
  let path = `M ${first.x} ${first.y}`;
  for (const [i, point] of rest.entries()) {
    const reach = Math.max(Math.abs(point.x - at.x) / 2, i === 0 || i === rest.length - 1 ? 18 : 0);
    const ahead = i === 0 || point.x >= at.x ? reach : -reach;
    const behind = i === rest.length - 1 || point.x >= at.x ? -reach : reach;
    path += ` C ${at.x + ahead} ${at.y} ${point.x + behind} ${point.y} ${point.x} ${point.y}`;
    at = point;
  }
  return path;
}

function middle(points: readonly Point[]): [number, number] {
  const i = Math.floor((points.length - 1) / 2);
  const one = points[i] as Point;
  const other = points.length % 2 === 1 ? one : (points[i + 1] as Point);
  return [(one.x + other.x) / 2, (one.y + other.y) / 2];
}
