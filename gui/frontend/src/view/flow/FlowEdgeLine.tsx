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
  const points = loop ? around(from, to, Number(data?.["bottom"] ?? Math.max(sourceY, targetY) + 40)) : bends.length > 1 || back ? [from, ...bends, to] : [from, to];
  const [path, x, y] = points.length === 2 ? getBezierPath(props) : [loop ? round(points) : smooth(points), ...middle(points)];
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

/** Round below the node, which ends at `bottom`, back to its own entry. */
function around(from: Point, to: Point, bottom: number): Point[] {
  const below = bottom + 18;
  return [from, { x: from.x + 24, y: (from.y + below) / 2 }, { x: (from.x + to.x) / 2, y: below }, { x: to.x - 24, y: (to.y + below) / 2 }, to];
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

/** A curve round a node through five points: out to the right, down, along below, up, and in from the left. */
function round(points: readonly Point[]): string {
  const [from, right, low, left, to] = points as [Point, Point, Point, Point, Point];
  const r = 12;
  return [
    `M ${from.x} ${from.y} H ${right.x - r} Q ${right.x} ${from.y} ${right.x} ${from.y + r}`,
    `V ${low.y - r} Q ${right.x} ${low.y} ${right.x - r} ${low.y}`,
    `H ${left.x + r} Q ${left.x} ${low.y} ${left.x} ${low.y - r}`,
    `V ${to.y + r} Q ${left.x} ${to.y} ${left.x + r} ${to.y} H ${to.x}`,
  ].join(" ");
}

function middle(points: readonly Point[]): [number, number] {
  const i = Math.floor((points.length - 1) / 2);
  const one = points[i] as Point;
  const other = points.length % 2 === 1 ? one : (points[i + 1] as Point);
  return [(one.x + other.x) / 2, (one.y + other.y) / 2];
}
