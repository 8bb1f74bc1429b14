/** The page: what it is made of, and what happens when it opens. */
import { ReactFlowProvider } from "@xyflow/react";
import { type CSSProperties, type JSX, lazy, Suspense, useEffect, useState } from "react";

import { processNotices } from "../model/words";
import { server } from "../protocol/client";
import { useBegin } from "../store/begin";
import { connect, openTask } from "../store/desk";
import { useDocument } from "../store/document";
import { save, takeFromDisk, typeText, undo } from "../store/editing";
import { useRobot } from "../store/live";
import { usePage } from "../store/page";
import { usePanes } from "../store/panes";
import { useRun } from "../store/run";
import { lookAgainOnReturn } from "../store/running";
import { loadProject, useProject } from "../store/tasks";
import { Foot } from "./Foot";
import { Outline } from "./Outline";
import { VariablesPanel } from "./SidePanel";
import { TopBar } from "./TopBar";
import { TreeCanvas } from "./TreeCanvas";
import { Ask } from "./edit/Ask";
import { EditBar } from "./edit/EditBar";
import { Inspector } from "./edit/Inspector";
import { Palette } from "./edit/Palette";
import { useKeys, useStudy } from "./hooks";
import { Divider } from "./marks";

const StartPage = lazy(() => import("./start/StartPage"));
const SetupPage = lazy(() => import("./setup/SetupPage"));

const IN_PARTS = new Set(["outline", "node", "split"]);

export function Page(): JSX.Element {
  const project = useProject((s) => s.project);
  const [error, setError] = useState("");
  const title = useRun((s) => s.task.name);
  useEffect(() => {
    let disconnect: (() => void) | undefined;
    let left = false;
    void server.catalog().then(useDocument.getState().setCatalog, (error: unknown) => setError(String(error)));
    loadProject()
      .then(async (found) => {
        if (left) return;
        const wanted = new URLSearchParams(location.search);
        const first = wanted.get("task") ?? found.selected ?? found.tasks[0]?.path;
        if (first) await openTask(first);
        showContainer(wanted.get("at"));
        if (!left) disconnect = connect();
      })
      .catch((error: unknown) => setError(String(error)));
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
  useStudy();
  const said = useDocument((s) => s.said);
  const room = usePage((s) => s.room);
  const shown = useRun((s) => s.task.path);
  const made = useBegin((s) => s.made !== null);
  const { sizes, hidden } = usePanes();
  // Of a project that was just made, it is told what it has until its first task is opened.
  const begins = useBegin((s) => s.choosing) || (shown === "" && (project?.tasks.length === 0 || made));

  if (!project) return <p className="hint padded">{error || "Opening the project ..."}</p>;
  return (
    <div className={`page room-${room}${[...hidden].map((pane) => ` no-${pane}`).join("")}`} style={Object.fromEntries(Object.entries(sizes).map(([pane, size]) => [`--${pane}`, IN_PARTS.has(pane) ? `${size}%` : `${size}px`])) as CSSProperties}>
      <TopBar project={project} begins={begins} />
      <Notices foot={room !== "project" && !begins} />
      {room === "project" ? (
        <Suspense fallback={<p className="hint padded">Loading the project's files ...</p>}>
          <SetupPage />
        </Suspense>
      ) : begins ? (
        <Suspense fallback={<p className="hint padded">Opening ...</p>}>
          <StartPage />
        </Suspense>
      ) : (
        <TaskRoom />
      )}
      <Ask />
      {room === "project" && (
        <output className="hidden" aria-live="polite" aria-label="What was done">
          {said}
        </output>
      )}
    </div>
  );
}

function TaskRoom(): JSX.Element {
  return (
    <>
      <aside className="left" aria-label="Outline and palette">
        <Outline />
        <Palette />
        <Divider pane="left" across="x" grows={1} />
        <Divider pane="outline" across="y" grows={1} part />
      </aside>
      <main aria-label="Views">
        <EditBar />
        <Stage />
      </main>
      <aside className="right" aria-label="Details">
        <Inspector />
        <VariablesPanel />
        <Divider pane="right" across="x" grows={-1} />
        <Divider pane="node" across="y" grows={1} part />
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
    <div className={`stage stage-${view === "robot" ? "3d" : view}${robot && view !== "robot" ? " stage-robot" : ""}`}>
      {stale && (
        <p className="stale-note" role="status">
          {drawn ? "The text is not a valid task: the last valid version is shown." : "This file is not a valid task yet; fix its text."}{" "}
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
      </Suspense>
      {(robot || view === "robot") && (
        <Suspense fallback={<p className="hint padded loading">Loading the 3D view ...</p>}>
          <RobotView />
        </Suspense>
      )}
      {view === "split" && !robot && <Divider pane="split" across="x" grows={1} part />}
    </div>
  );
}

/** @param foot whether there is a bar below, which tells what is no fault: nothing moves for that. */
function Notices({ foot }: { foot: boolean }): JSX.Element {
  const message = useRun((s) => s.error);
  const session = useRun((s) => s.session);
  const error = useRun((s) => s.moment.facts.error);
  return (
    <div className="notices">
      <Gone />
      <Conflicts />
      {message && (
        <div className="notice bad" role="alert">
          <p>{message}</p>
          <button onClick={() => useRun.getState().setError("")}>Close</button>
        </div>
      )}
      {processNotices(session).filter(({ bad }) => bad || !foot).map(({ text, bad }) => (
        <div key={text} className={`notice${bad ? " bad" : ""}`} role={bad ? "alert" : "status"}>
          <pre>{text}</pre>
        </div>
      ))}
      {error && (
        <div className="notice bad" role="alert">
          <details>
            <summary>
              {error.path}: {error.type}: {error.message}
            </summary>
            <pre>{error.traceback}</pre>
          </details>
          <button onClick={() => usePage.getState().select(error.path)}>Show</button>
        </div>
      )}
    </div>
  );
}

/** The server is away: what that means, and what happens when it is back. */
function Gone(): JSX.Element | null {
  const gone = useRun((s) => s.connected === false);
  const stranger = useRun((s) => s.stranger);
  const waiting = useDocument((s) => s.waiting);
  if (!gone) return null;
  const kept = waiting > 0 ? `${waiting} ${waiting === 1 ? "edit waits" : "edits wait"} for it.` : "What you type is kept.";
  return (
    <div className="notice bad" role="alert">
      <p>
        <strong>{stranger ? "The server was started anew, and this page doesn't belong to it." : "The server doesn't answer."}</strong> What runs can't be seen or stopped from here: use the robot's own stop. {kept}{" "}
        {stranger ? "Open the address that grip edit has printed, in this tab." : "Start grip edit again where it ran: this page comes back by itself."}
      </p>
    </div>
  );
}

export function Conflicts(): JSX.Element {
  const conflict = useDocument((s) => s.conflict);
  const document = useDocument((s) => s.document);
  const record = useRun((s) => s.record);
  const { setConflict } = useDocument.getState();
  const changed = record === null && document !== null && document.change !== "" && conflict?.kind !== "disk";
  return (
    <>
      {conflict && (
        <div className="notice bad" role="alert">
          <p>{conflict.message}</p>
          <span className="buttons">
            {conflict.kind === "disk" && <DiskButtons />}
            {conflict.kind === "stale" && conflict.text !== undefined && (
              <>
                <button onClick={() => void typeText(conflict.text as string, null)}>Overwrite with my text</button>
                <button onClick={() => useDocument.getState().resetText()}>Use the new text</button>
              </>
            )}
            {conflict.kind === "unfinished" && (
              <>
                <button onClick={() => usePage.getState().setView("text")}>Show the text</button>
                <button onClick={() => void undo()}>Drop it</button>
              </>
            )}
            <button onClick={() => setConflict(null)}>Close</button>
          </span>
        </div>
      )}
      {changed && (
        <div className="notice" role="status">
          <p>The file was {document.change} outside the editor.</p>
          <span className="buttons">
            <DiskButtons />
          </span>
        </div>
      )}
    </>
  );
}

function DiskButtons(): JSX.Element {
  const change = useDocument((s) => s.document?.change);
  return (
    <>
      {change === "changed" && <button onClick={() => void takeFromDisk()}>Reload from the file</button>}
      <button onClick={() => void save(true)}>Overwrite the file</button>
    </>
  );
}
