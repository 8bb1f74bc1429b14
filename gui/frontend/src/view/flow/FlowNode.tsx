/** What stands in a flow chart: a child with its outcomes as ports, an end of the container, the mark of the start. */
import { Handle, type NodeProps, Position } from "@xyflow/react";
import type { JSX } from "react";

import type { FlowItem } from "../../model/flow";
import { IDLE } from "../../model/status";
import { KINDS, statusText } from "../../model/words";
import { usePage } from "../../store/page";
import { useRun } from "../../store/run";
import { useForm } from "../edit/FormBadge";
import { KindIcon, PhaseIcon } from "../icons";
import { OthersRing } from "../Others";
import { NodeSub } from "../NodeSub";
import { HoldMark, lensMark, ProblemMark } from "../marks";

export function FlowNode({ data }: NodeProps): JSX.Element {
  const item = data["item"] as FlowItem;
  const node = item.node as NonNullable<FlowItem["node"]>;
  const status = useRun((s) => s.moment.nodes.get(node.path) ?? IDLE);
  const selected = usePage((s) => s.marked.has(node.path));
  const lens = usePage((s) => s.lens);
  const form = useForm(node.path);
  const open = usePage((s) => s.opened.has(node.path));
  const kind = node.kind === "leaf" ? node.label : [KINDS[node.kind], node.label].filter(Boolean).join(", ");
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
