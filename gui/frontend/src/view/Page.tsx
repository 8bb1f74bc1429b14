/** The page: what it is made of, and what happens when it opens. */
import { ReactFlowProvider } from "@xyflow/react";
import { type JSX, useEffect, useState } from "react";

import { server } from "../protocol/client";
import type { ProjectView } from "../protocol/generated";
import { connect, openTask } from "../store/desk";
import { useRun } from "../store/run";
import { EventLog } from "./EventLog";
import { Notices } from "./Notices";
import { Outline } from "./Outline";
import { Problems } from "./Problems";
import { NodePanel, VariablesPanel } from "./SidePanel";
import { TimeLine } from "./TimeLine";
import { TopBar } from "./TopBar";
import { TreeCanvas } from "./TreeCanvas";

export function Page(): JSX.Element {
  const [project, setProject] = useState<ProjectView | null>(null);
  const [trouble, setTrouble] = useState("");
  const title = useRun((s) => s.task.name);
  useEffect(() => {
    let disconnect: (() => void) | undefined;
    let left = false;
    server
      .project()
      .then(async (found) => {
        if (left) return;
        setProject(found);
        const first = found.selected ?? found.tasks[0]?.path;
        if (first) await openTask(first);
        if (!left) disconnect = connect();
      })
      .catch((error: unknown) => setTrouble(String(error)));
    return () => {
      left = true;
      disconnect?.();
    };
  }, []);
  useEffect(() => {
    document.title = title ? `${title} - GRIP` : "GRIP";
  }, [title]);

  if (!project) return <p className="hint padded">{trouble || "Opening the project ..."}</p>;
  return (
    <div className="page">
      <TopBar project={project} />
      <Notices />
      <aside className="left" aria-label="Outline">
        <Outline />
        <Problems />
      </aside>
      <main aria-label="Tree">
        {project.tasks.length === 0 && <p className="hint padded">No task files in tasks/ yet.</p>}
        <ReactFlowProvider>
          <TreeCanvas />
        </ReactFlowProvider>
      </main>
      <aside className="right" aria-label="Details">
        <NodePanel />
        <VariablesPanel />
      </aside>
      <footer>
        <TimeLine />
        <EventLog />
      </footer>
    </div>
  );
}
