/** What stands in a flow chart: a child with its outcomes as ports, an end of the container, the mark of the start. */
import { BaseEdge, EdgeLabelRenderer, type EdgeProps, getBezierPath, Handle, type NodeProps, Position } from "@xyflow/react";
import type { JSX } from "react";

import type { FlowItem } from "../../model/flow";
import type { Point } from "../../model/flowLayout";
import { kindTitle } from "../../model/kinds";
import { statusText } from "../../model/words";
import { IDLE } from "../../model/status";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";
import { OthersRing } from "../Presence";
import { NodeSub } from "../TreeNode";
import { useForm } from "../edit/EditBar";
import { HoldMark, lensMark, ProblemMark } from "../marks";
import { KindIcon, PhaseIcon } from "../icons";

export function FlowNode({ data }: NodeProps): JSX.Element {
  const item = data["item"] as FlowItem;
  const node = item.node as NonNullable<FlowItem["node"]>;
  const status = useRun((s) => s.moment.nodes.get(node.path) ?? IDLE);
  const selected = usePage((s) => s.marked.has(node.path));
  const lens = usePage((s) => s.lens);
  const form = useForm(node.path);
  const open = usePage((s) => s.opened.has(node.path));
  const kind = node.kind === "leaf" ? node.label : [kindTitle(node.kind), node.label].filter(Boolean).join(", ");
  return (
    <div className={`node flow-node${open ? " open" : ""} kind-${node.kind} is-${status.phase}${selected ? " selected" : ""}`} data-path={node.path} title={node.doc}>
      <OthersRing path={node.path} folded={!open} />
      <Handle type="target" position={Position.Left} id="in" />
      <div className="node-head">
        {node.children.length > 0 && <Open node={node} />}
        <KindIcon kind={node.kind} id={node.label} />
        <span className="node-name">{node.name}</span>
        <HoldMark path={node.path} />
        <ProblemMark path={node.path} />
        {lensMark(node, lens)}
        {form && !form.both && <span className="form-badge" title={form.reason}>~</span>}
        <span className={`badge phase-${status.phase}`}>
          <PhaseIcon phase={status.phase} />
          {status.phase === "idle" ? "" : statusText(status)}
        </span>
      </div>
      <NodeSub node={node} what={node.children.length > 0 ? `${kind}: ${node.children.length} inside` : kind} />
      <ul className="ports">
        {item.ports.map((port) => (
          <li key={port.outcome} className={`port ${port.meaning}${port.led ? "" : " free"}`}>
            {port.outcome}
            <Handle type="source" position={Position.Right} id={port.outcome} title={`${node.name}.${port.outcome}: drag to where it leads`} />
          </li>
        ))}
      </ul>
    </div>
  );
}

/** Shows the inside of a container in its box, or closes it. */
function Open({ node }: { node: NonNullable<FlowItem["node"]> }): JSX.Element {
  const open = usePage((s) => s.opened.has(node.path));
  return (
    <button
      className={`fold nodrag${open ? "" : " closed"}`}
      aria-expanded={open}
      aria-label={`Inside of ${node.name} in place`}
      title={open ? "Close" : "Open in place; a double click goes in"}
      tabIndex={-1}
      onClick={(event) => {
        event.stopPropagation();
        usePage.getState().openInPlace(node.path, !open);
      }}
      onDoubleClick={(event) => event.stopPropagation()}
    >
      <span className={`twisty ${open ? "open" : "closed"}`} />
    </button>
  );
}

export function EndNode({ data }: NodeProps): JSX.Element {
  const item = data["item"] as FlowItem;
  return (
    <div className={`end-node ${item.meaning}`}>
      <Handle type="target" position={Position.Left} id="in" />
      <span>⇥ {item.outcome}</span>
    </div>
  );
}

export function StartNode(): JSX.Element {
  return (
    <div className="start-node" title="Here it begins">
      <Handle type="source" position={Position.Right} id="" isConnectable={true} />
    </div>
  );
}

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
