/** One node on the canvas. It holds no state of its own: canvases unmount what is out of sight. */
import { type NodeProps, NodeToolbar, Position, useStore } from "@xyflow/react";
import type { JSX } from "react";
import { IDLE } from "../model/status";
import { settingsOf } from "../model/values";
import { hasEdges, kindTitle } from "../model/kinds";
import { statusText } from "../model/words";
import type { NodeView, Transition } from "../protocol/generated";
import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { OthersRing } from "./Presence";
import { BriefSettings, briefSettings } from "./edit/ContainerForm";
import { useForm } from "./edit/EditBar";
import { Parameters, useFace } from "./edit/LeafForm";
import { useDropTarget } from "./hooks";
import { KindIcon, PhaseIcon } from "./icons";
import { HoldMark, lensMark, ProblemMark } from "./marks";
import { isNear } from "./drawing";

export function TreeNode({ data }: NodeProps): JSX.Element {
  const node = data["node"] as NodeView;
  const status = useRun((s) => s.moment.nodes.get(node.path) ?? IDLE);
  const selected = usePage((s) => s.marked.has(node.path));
  const lens = usePage((s) => s.lens);
  const closed = usePage((s) => s.closed.has(node.path));
  const inMachine = useRun((s) => hasEdges(s.index.byPath.get(node.parent ?? "")));
  const form = useForm(node.path);
  const target = useDropTarget(node.path);
  const said = status.phase === "idle" ? "" : (status.message ?? "");
  const again = status.activations > 1 ? ` ×${status.activations}` : "";
  return (
    <div
      className={`node nopan nodrag kind-${node.kind} is-${status.phase}${selected ? " selected" : ""}`}
      data-path={node.path}
      title={[node.doc, said].filter(Boolean).join("\n\n")}
      {...target}
    >
      <OthersRing path={node.path} folded={closed} />
      <div className="node-head">
        {node.children.length > 0 && <Fold node={node} />}
        <KindIcon kind={node.kind} id={node.label} />
        <span className="node-name">{node.name}</span>
        {node.initial && inMachine && <span className="initial">start</span>}
        <HoldMark path={node.path} />
        <ProblemMark path={node.path} />
        {lensMark(node, lens)}
        {form && !form.both && (
          <span className="form-badge" title={`one form only: ${form.reason}`}>
            ~
          </span>
        )}
        <span className={`badge phase-${status.phase}`}>
          <PhaseIcon phase={status.phase} />
          {status.phase === "idle" ? "" : statusText(status) + again}
        </span>
      </div>
      <NodeSub node={node} what={subtitle(node)} said={said} />
      {node.on.length > 0 && (
        <ul className="node-on">
          {node.on.map((edge) => (
            <li key={edge.outcome} className={isTaken(edge, node, status.outcome, status.code) ? "taken" : ""}>
              <span>{edge.outcome}</span> {edge.ends ? "⇥" : "→"} {edge.target}
            </li>
          ))}
        </ul>
      )}
    </div>
  );
}

/** Folds a container, or opens it; folded, it says how many are inside. */
function Fold({ node }: { node: NodeView }): JSX.Element {
  const closed = usePage((s) => s.closed.has(node.path));
  return (
    <button
      className={`fold${closed ? " closed" : ""}`}
      aria-expanded={!closed}
      aria-label={`Inside of ${node.name}`}
      tabIndex={-1}
      onClick={(event) => {
        event.stopPropagation();
        usePage.getState().setClosed(node.path, !closed);
      }}
      onDoubleClick={(event) => event.stopPropagation()}
    >
      <span className={`twisty ${closed ? "closed" : "open"}`} />
      {closed && node.children.length}
    </button>
  );
}

export function subtitle(node: NodeView): string {
  if (node.kind === "leaf") return node.label;
  const kind = kindTitle(node.kind);
  return node.label ? `${kind}, ${node.label}` : kind;
}

/** Whether this edge was followed: the most specific one wins. */
function isTaken(edge: Transition, node: NodeView, outcome?: string, code?: string): boolean {
  if (outcome === undefined) return false;
  const specific = code ? `${outcome}.${code}` : outcome;
  const hit = node.on.some((other) => other.outcome === specific) ? specific : outcome;
  return edge.outcome === hit;
}

/** @param said what the run says about the node, in place of what it is. */
export function NodeSub({ node, what, said = "" }: { node: NodeView; what: string; said?: string }): JSX.Element {
  const near = useStore(isNear);
  const selected = usePage((s) => s.selected === node.path);
  const settings = near ? settingsOf(node) : [];
  return (
    <>
      {said || settings.length === 0 ? (
        <div className={said ? "node-sub said" : "node-sub"}>{said || what}</div>
      ) : (
        <div className="node-sub near">
          {what}
          {settings.map(({ name, text }) => (
            <span key={name}>
              {" "}
              <i>{name}</i> {text}
            </span>
          ))}
        </div>
      )}
      {near && selected && <NearFields node={node} />}
    </>
  );
}

/** The settings of a node where it is drawn. They lie over what is below it, so that nothing moves. */
function NearFields({ node }: { node: NodeView }): JSX.Element | null {
  const face = useFace(node);
  const locked = useRun((s) => s.record !== null);
  const fields = briefSettings(node);
  const ports = node.kind === "leaf" || node.kind === "subtask";
  if (ports ? !face?.parameters.length : fields.length === 0) return null;
  return (
    <NodeToolbar isVisible position={Position.Bottom} align="start" offset={6} className="nopan nodrag nowheel">
      <div className="near-fields" role="group" aria-label={`Settings of ${node.name}, at the node`} onDoubleClick={(event) => event.stopPropagation()}>
        {ports && face ? <Parameters node={node} face={face} locked={locked} brief /> : <BriefSettings node={node} fields={fields} locked={locked} />}
      </div>
    </NodeToolbar>
  );
}
