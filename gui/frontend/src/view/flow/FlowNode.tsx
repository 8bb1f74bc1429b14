/** What stands in a flow chart: a child with its outcomes as ports, an end of the container, the mark of the start. */
import { BaseEdge, EdgeLabelRenderer, type EdgeProps, getSmoothStepPath, Handle, type NodeProps, Position } from "@xyflow/react";
import type { JSX } from "react";
import { type FlowItem, freeWidth, LEAD, PORT_HEIGHT, subtitleOf } from "../../model/flow";
import type { Point } from "../../model/layout";
import { statusText } from "../../model/words";
import { IDLE } from "../../model/status";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";
import { OthersRing } from "../Presence";
import { NodeSub } from "../TreeNode";
import { useForm } from "../edit/EditBar";
import { KindIcon, PhaseIcon } from "../icons";
import { HoldMark, lensMark, ProblemMark } from "../marks";

/** What stands before the names of the handles on a box's border that what is inside it leads to. */
export const INSIDE = "#inside:";

/** What the sign and the colour say already: the words would cover what the node does. */
const PLAIN = new Set(["running", "success"]);

export function FlowNode({ data }: NodeProps): JSX.Element {
  const item = data["item"] as FlowItem;
  const node = item.node as NonNullable<FlowItem["node"]>;
  const status = useRun((s) => s.moment.nodes.get(node.path) ?? IDLE);
  const selected = usePage((s) => s.marked.has(node.path));
  const lens = usePage((s) => s.lens);
  const form = useForm(node.path);
  const open = usePage((s) => s.opened.has(node.path));
  const places = data["ports"] as ReadonlyMap<string, Point> | null;
  const entry = places?.get("")?.y ?? LEAD;
  return (
    <div className={`node flow-node${open ? " open" : ""} kind-${node.kind} is-${status.phase}${selected ? " selected" : ""}`} data-path={node.path} title={node.doc}>
      <OthersRing path={node.path} folded={!open} />
      <Handle type="target" position={Position.Left} id="in" style={{ top: entry }} />
      {places && <Handle type="source" className="inside" position={Position.Left} id={INSIDE} style={{ top: entry }} title={`Drag to where ${node.name} begins`} />}
      <div className="node-head">
        {node.children.length > 0 && <Open node={node} />}
        <KindIcon kind={node.kind} id={node.label} />
        <span className="node-name">{node.name}</span>
        <HoldMark path={node.path} />
        <ProblemMark path={node.path} />
        {lensMark(node, lens)}
        {form && !form.both && <span className="form-badge" title={form.reason}>~</span>}
      </div>
      <div className="flow-sub" style={{ paddingInlineEnd: freeWidth(item.ports) }}>
        <NodeSub node={node} what={subtitleOf(node)} />
        <span className={`badge phase-${status.phase}`}>
          <PhaseIcon phase={status.phase} />
          {status.phase !== "idle" && <span className={PLAIN.has(statusText(status)) ? "hidden" : ""}>{statusText(status)}</span>}
        </span>
      </div>
      <ul className="ports">
        {item.ports.map((port, i) => (
          <li key={port.outcome} className={`port ${port.meaning}${port.led ? "" : " free"}`} data-outcome={port.outcome} style={{ top: (places?.get(port.outcome)?.y ?? LEAD + i * PORT_HEIGHT) - PORT_HEIGHT / 2 }}>
            <span className={port.led ? "hidden" : ""}>{port.outcome}</span>
            <Handle type="source" position={Position.Right} id={port.outcome} title={`${node.name}.${port.outcome}: drag to where it leads`} />
            {places && <Handle type="target" className="inside" position={Position.Right} id={INSIDE + port.outcome} />}
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
  const { id, sourceX, sourceY, data, label, markerEnd, selected } = props;
  const points = data?.["points"] as readonly Point[];
  const words = data?.["words"] as Point | null;
  // While one of its ends is dragged it follows at once; it is laid out when that is dropped.
  const free = data?.["free"] === true;
  const path = free ? getSmoothStepPath(props)[0] : roundedToDot(points);
  const at = free ? { x: sourceX + 40, y: sourceY } : words;
  return (
    <>
      <BaseEdge id={id} path={path} interactionWidth={18} {...(markerEnd ? { markerEnd } : {})} />
      {label !== undefined && at && (
        <EdgeLabelRenderer>
          <span className={`edge-label ${(data?.["meaning"] as string | undefined) ?? ""}${selected ? " selected" : ""}`} data-edge={id} style={{ transform: `translate(-50%, -50%) translate(${at.x}px, ${at.y}px)` }}>
            {label}
          </span>
        </EdgeLabelRenderer>
      )}
    </>
  );
}

const RADIUS = 8;
const DOT = 5;

/** The arrow ends before the dot of the entry, which would cover it. */
function toDot(points: readonly Point[]): readonly Point[] {
  const last = points.at(-1);
  return last === undefined ? points : [...points.slice(0, -1), { x: last.x - DOT, y: last.y }];
}

/** Level and upright pieces with round corners. */
export function roundedToDot(points: readonly Point[]): string {
  const [first, ...rest] = toDot(points) as [Point, ...Point[]];
  let path = `M ${first.x} ${first.y}`;
  for (const [i, point] of rest.entries()) {
    const before = (rest[i - 1] ?? first) as Point;
    const after = rest[i + 1];
    const [a, b] = [Math.hypot(point.x - before.x, point.y - before.y), after ? Math.hypot(after.x - point.x, after.y - point.y) : 0];
    const r = Math.min(RADIUS, a / 2, b / 2);
    if (!after || r < 0.5) {
      path += ` L ${point.x} ${point.y}`;
      continue;
    }
    const toward = (other: Point, length: number): string => `${point.x + ((other.x - point.x) / length) * r} ${point.y + ((other.y - point.y) / length) * r}`;
    path += ` L ${toward(before, a)} Q ${point.x} ${point.y} ${toward(after, b)}`;
  }
  return path;
}
