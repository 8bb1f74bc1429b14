/** The views of the task, one or two of them; what isn't needed at first is loaded when it is. */
import { ReactFlowProvider } from "@xyflow/react";
import { type JSX, lazy, Suspense } from "react";

import { useDocument } from "../store/document";
import { usePage } from "../store/page";
import { useRobot } from "../store/robot";
import { useRun } from "../store/run";
import { TreeCanvas } from "./TreeCanvas";

const RobotView = lazy(() => import("./robot/RobotView"));
const TextPane = lazy(() => import("./text/TextPane"));
const FlowCanvas = lazy(async () => ({ default: (await import("./flow/FlowCanvas")).FlowCanvas }));

export function Stage(): JSX.Element {
  const view = usePage((s) => s.view);
  const beside = usePage((s) => s.beside);
  const path = useRun((s) => s.task.path);
  const drawn = useRun((s) => s.task.nodes.length > 0);
  const stale = useDocument((s) => s.document?.draft === true) && view !== "text";
  const robot = useRobot((s) => s.open);
  return (
    <div className={`stage stage-${view}${robot ? " stage-robot" : ""}`}>
      {stale && (
        <p className="stale-note" role="status">
          {drawn ? "The text isn't a task at the moment: this is the last one that it was." : "This file isn't a task yet; its text has to be mended."}{" "}
          <button onClick={() => usePage.getState().setView("text")}>Show the text</button>
        </p>
      )}
      <Suspense fallback={<p className="hint padded">Loading the view ...</p>}>
        {(view === "tree" || view === "split") && (
          <ReactFlowProvider>
            <TreeCanvas />
          </ReactFlowProvider>
        )}
        {(view === "flow" || (view === "split" && beside === "flow")) && (
          <ReactFlowProvider>
            <FlowCanvas />
          </ReactFlowProvider>
        )}
        {(view === "text" || (view === "split" && beside === "text")) && <TextPane key={path} />}
        {robot && <RobotView />}
      </Suspense>
    </div>
  );
}
