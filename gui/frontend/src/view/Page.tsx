/** The page: what it is made of, and what happens when it opens. */
import { type JSX, lazy, Suspense, useEffect, useState } from "react";

import { server } from "../protocol/client";
import { connect, openTask } from "../store/desk";
import { useDocument } from "../store/document";
import { usePage } from "../store/page";
import { lookAgainOnReturn } from "../store/returning";
import { useRun } from "../store/run";
import { loadProject, newTask, useProject } from "../store/tasks";
import { Ask } from "./edit/Ask";
import { EditBar } from "./edit/EditBar";
import { Inspector } from "./edit/Inspector";
import { Palette } from "./edit/Palette";
import { useKeys } from "./edit/useKeys";
import { Foot } from "./Foot";
import { Notices } from "./Notices";
import { Outline } from "./Outline";
import { VariablesPanel } from "./SidePanel";
import { Stage } from "./Stage";
import { TopBar } from "./TopBar";

const SetupPage = lazy(() => import("./setup/SetupPage"));

export function Page(): JSX.Element {
  const project = useProject((s) => s.project);
  const [trouble, setTrouble] = useState("");
  const title = useRun((s) => s.task.name);
  useEffect(() => {
    let disconnect: (() => void) | undefined;
    let left = false;
    void server.catalog().then(useDocument.getState().setCatalog, (error: unknown) => setTrouble(String(error)));
    loadProject()
      .then(async (found) => {
        if (left) return;
        const wanted = new URLSearchParams(location.search);
        const first = wanted.get("task") ?? found.selected ?? found.tasks[0]?.path;
        if (first) await openTask(first);
        showContainer(wanted.get("at"));
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

  useEffect(() => lookAgainOnReturn(), []);
  useKeys();
  const said = useDocument((s) => s.said);
  const room = usePage((s) => s.room);

  if (!project) return <p className="hint padded">{trouble || "Opening the project ..."}</p>;
  return (
    <div className="page">
      <TopBar project={project} />
      <Notices />
      {room === "project" ? (
        <Suspense fallback={<p className="hint padded">Loading the project's files ...</p>}>
          <SetupPage />
        </Suspense>
      ) : (
        <TaskRoom empty={project.tasks.length === 0} />
      )}
      <Ask />
      <output className="hidden" aria-live="polite" aria-label="What was done">
        {said}
      </output>
    </div>
  );
}

function TaskRoom({ empty }: { empty: boolean }): JSX.Element {
  return (
    <>
      <aside className="left" aria-label="Outline and palette">
        <Outline />
        <Palette />
      </aside>
      <main aria-label="Views">
        <EditBar />
        {empty ? (
          <p className="hint padded">
            No task files in tasks/ yet. <button onClick={() => void newTask()}>New task</button>
          </p>
        ) : (
          <Stage />
        )}
      </main>
      <aside className="right" aria-label="Details">
        <Inspector />
        <VariablesPanel />
      </aside>
      <Foot />
    </>
  );
}

/** Show the inside of a container: a pane of its own was opened for it. */
function showContainer(path: string | null): void {
  if (path === null || !useRun.getState().index.byPath.has(path)) return;
  usePage.getState().select(path);
  usePage.getState().enter(path);
  usePage.getState().setView("flow");
}
