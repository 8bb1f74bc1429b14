/** The second line of a node: what it is; near, also what it is set to, with fields below the one that is selected. */
import { NodeToolbar, Position, useStore } from "@xyflow/react";
import type { JSX } from "react";

import { settingsOf } from "../model/settings";
import type { NodeView } from "../protocol/generated";
import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { isNear } from "./Detail";
import { BriefSettings, useBriefSettings } from "./edit/ContainerForm";
import { Parameters, useFace } from "./edit/LeafForm";

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
  const fields = useBriefSettings(node);
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
