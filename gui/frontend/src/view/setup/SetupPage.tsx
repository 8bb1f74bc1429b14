/** The files that put a project together: a list, the open one as a form, and as text beside it. */
import "./setup.css";
import { type JSX, type KeyboardEvent as KeyPress, lazy, Suspense, useEffect, useState } from "react";

import { formKind, freeName, type Shape, shapeAt, valueAt } from "../../model/shapes";
import type { SetupView, Template } from "../../protocol/generated";
import { goOn, useBegin } from "../../store/begin";
import { loadGeometry, useRobot } from "../../store/live";
import { listSetup, type Making, openSetup, type Part, probe, saveSetup, setValue, report, useSetup } from "../../store/setup";
import { ImportForm, InterfaceForm } from "./ImportForm";
import { MessagesPage, NamedInSpace } from "./MessagesPage";
import { ProjectParts, World, WorldPicture } from "./ProjectParts";
import { MotionForm, SchemaForm } from "./SchemaForm";
import { SetupText } from "./SetupText";
import { SensorsPage, TopicsPage } from "./TopicsPage";
import { TryForm } from "./TryForm";

const TITLES: Record<Exclude<Making, null>, string> = { component: "New component", import: "Import a task", topics: "Topics", messages: "Message server" };

export default function SetupPage(): JSX.Element {
  const view = useSetup((s) => s.view);
  const making = useSetup((s) => s.making);
  const setMaking = (what: Making): void => useSetup.setState({ making: what });
  useEffect(() => {
    listSetup()
      .then(() => (useSetup.getState().view === null ? openSetup("grip.yaml") : undefined))
      .catch(report);
  }, []);
  useEffect(() => {
    window.addEventListener("keydown", onKeyDown);
    return () => window.removeEventListener("keydown", onKeyDown);
  }, []);
  return (
    <div className="setup">
      <Files making={making} make={setMaking} />
      {making ? (
        <main className="panel padded setup-new" aria-label={TITLES[making]}>
          {making === "component" && <InterfaceForm done={() => setMaking(null)} />}
          {making === "import" && <ImportForm />}
          {making === "topics" && <TopicsPage done={() => setMaking(null)} />}
          {making === "messages" && <MessagesPage />}
        </main>
      ) : (
        view && <Open key={view.path} view={view} />
      )}
    </div>
  );
}

/** Parts of grip.yaml that have a page of their own. */
const PARTS: readonly [Part, string, string][] = [
  ["motion", "Planners and kinematics", "of each arm, with their numbers"],
  ["sensors", "Sensors", "what they see, live"],
];

const MADE: readonly [Exclude<Making, null>, string, string][] = [
  ["topics", TITLES.topics, "of the ROS graph: receive one, make a sensor"],
  ["messages", TITLES.messages, "live: look, add, change, record"],
  ["component", TITLES.component, "from a .srv or .action"],
  ["import", TITLES.import, "from SMACH, BehaviorTree.CPP, py_trees"],
];

function onKeyDown(event: KeyboardEvent): void {
  if (!(event.ctrlKey || event.metaKey) || event.key !== "s") return;
  event.preventDefault();
  // What was typed into a field counts when the field is left.
  if (event.target instanceof HTMLInputElement) event.target.blur();
  void saveSetup();
}

function Files({ making, make }: { making: Making; make: (what: Making) => void }): JSX.Element {
  const files = useSetup((s) => s.files);
  const path = useSetup((s) => s.view?.path);
  const shown = useSetup((s) => s.part);
  const entry = (file: string, part: Part, title: string, hint: string, doc?: string): JSX.Element => (
    <li key={file + part}>
      <button
        className="setup-file"
        aria-current={making === null && file === path && part === shown ? "page" : undefined}
        title={doc}
        onClick={() => {
          make(null);
          useSetup.setState({ part });
          void openSetup(file);
        }}
      >
        {title}
        <code>{hint}</code>
      </button>
    </li>
  );
  return (
    <nav className="panel" aria-label="Files of the project">
      <h2>Project</h2>
      <ul className="plain scroll">
        {files.map((file) => [entry(file.path, "", file.title, file.exists ? file.path : "not there yet", file.doc), ...(file.path === "grip.yaml" ? PARTS.map(([part, title, hint]) => entry(file.path, part, title, hint)) : [])])}
        <li className="setup-head" aria-hidden="true">
          More
        </li>
        {MADE.map(([what, label, hint]) => (
          <li key={what}>
            <button className="setup-file" aria-current={making === what ? "page" : undefined} onClick={() => make(what)}>
              {label}
              <code>{hint}</code>
            </button>
          </li>
        ))}
      </ul>
    </nav>
  );
}

const TEXT_SHOWN = "grip.setup.text";

function Open({ view }: { view: SetupView }): JSX.Element {
  const [text, setText] = useState(() => localStorage.getItem(TEXT_SHOWN) === "yes");
  const line = useSetup((s) => s.line);
  const tried = useSetup((s) => s.probe !== null);
  function show(yes: boolean): void {
    localStorage.setItem(TEXT_SHOWN, yes ? "yes" : "no");
    if (!yes) useSetup.setState({ line: null });
    setText(yes);
  }
  // Who presses a problem's line wants to see it.
  if (line !== null && !text) show(true);
  const saved = useSetup((s) => s.saved === s.view?.text);
  const busy = useSetup((s) => s.busy);
  const wanted = useBegin((s) => s.wanted !== null);
  const chosen = useSetup((s) => s.part);
  const part = view.kind === "project" ? chosen : "";
  const tries: readonly (readonly ["robot" | "generate" | "test", string])[] =
    view.kind === "component" ? [["generate", "Generate the node"], ["test", "Try it"]] : view.kind === "project" ? [["robot", "Check the robot"]] : [];
  return (
    <>
      <main className={text || tried ? "panel" : "panel alone"} aria-label={view.title}>
        <div className="edit-bar" role="toolbar" aria-label="File">
          <strong>{PARTS.find(([name]) => name === part)?.[1] ?? view.title}</strong> <code>{view.path}</code>
          <span className="grow" />
          <Templates view={view} />
          {tries.map(([what, label]) => (
            <button key={what} disabled={busy !== ""} onClick={() => void probe(what)}>
              {busy === what ? "Trying ..." : label}
            </button>
          ))}
          {wanted && view.kind === "component" && saved && (
            <button className="main" onClick={() => void goOn(`component/${(view.data as { name?: string } | null)?.name ?? ""}`)}>
              Add it to the task
            </button>
          )}
          <button aria-pressed={text} title="The file itself, beside the form" onClick={() => show(!text)}>
            Text
          </button>
          <button className={saved ? "" : "main"} disabled={saved} onClick={() => void saveSetup()}>
            Save
          </button>
          <output aria-label="State of the file">{saved ? "saved" : "not saved"}</output>
        </div>
        <div className="scroll padded" tabIndex={0} role="group" aria-label="Form">
          <Found view={view} />
          {part === "motion" && <MotionForm view={view} />}
          {part === "sensors" && <SensorsPage view={view} />}
          {view.kind === "project" && part === "" && <ProjectParts />}
          {view.kind === "project" && part === "" && <OwnRobot robot={JSON.stringify((view.data as { robot?: unknown } | null)?.robot ?? null)} />}
          {view.kind === "world" && (
            <div key={view.path} className="worlds">
              <World data={view.data} />
              <WorldPicture name={view.path.replace(/^worlds\/|\.yaml$/g, "")} cameras={Object.keys((view.data as { cameras?: object } | null)?.cameras ?? {})} />
            </div>
          )}
          {view.path.startsWith("messages/") && <NamedInSpace view={view} />}
          {view.kind === "component" && <TryForm path={view.path} />}
          {part === "" && <SchemaForm view={view} />}
        </div>
      </main>
      {(text || tried) && (
        <aside className="panel" aria-label="Text">
          {text && <SetupText />}
          <Tried />
        </aside>
      )}
    </>
  );
}

const RobotPreview = lazy(() => import("../robot/RobotPreview"));

/** The robot of the saved file: in 3D, with its joints; folded until somebody looks. */
function OwnRobot({ robot }: { robot: string }): JSX.Element | null {
  const [open, setOpen] = useState(false);
  const view = useRobot((s) => s.view);
  const saved = useSetup((s) => s.saved === s.view?.text);
  useEffect(() => {
    if (open && saved) void loadGeometry();
  }, [open, saved, robot]);
  if (robot === "null") return null;
  return (
    <details className="own-robot" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>The robot in 3D: joints, named states, what its files said</summary>
      {open && (
        <Suspense fallback={<p className="hint loading">Loading the 3D view ...</p>}>
          <RobotPreview view={saved ? view : null} moves />
        </Suspense>
      )}
    </details>
  );
}

function Found({ view }: { view: SetupView }): JSX.Element | null {
  const checking = useSetup((s) => s.checking);
  if (checking) return <p className="hint" role="status">Checking ...</p>;
  if (view.problems.length === 0) return <p className="phase-success">✓ Nothing is wrong with it.</p>;
  return (
    <ul className="plain setup-problems" aria-label="Problems of the file">
      {view.problems.map((problem) => (
        <li key={`${problem.line} ${problem.message}`}>
          <button className={`link ${problem.severity === "error" ? "fault" : "doubt"}`} onClick={() => useSetup.setState({ line: problem.line })}>
            line {problem.line}
          </button>{" "}
          {problem.severity === "warning" && "maybe: "}
          {problem.message}
        </li>
      ))}
    </ul>
  );
}

function Templates({ view }: { view: SetupView }): JSX.Element | null {
  if (view.templates.length === 0) return null;
  function insert(template: Template): void {
    const above = template.key.slice(0, -1);
    const last = template.key.at(-1) ?? "";
    // Names that people give get a number; a field has one value.
    const named = formKind(shapeAt(view.shape as Shape, above)) === "entries";
    void setValue((now) => {
      const parent = valueAt(now.data, above);
      return [...above, named && typeof parent === "object" && parent !== null ? freeName(last, Object.keys(parent)) : last];
    }, template.value);
  }
  return (
    <select aria-label="Insert a template" value="" onKeyDown={openFirst} onChange={(event) => view.templates.filter((each) => each.title === event.target.value).forEach(insert)}>
      <option value="">Insert ...</option>
      {view.templates.map((template) => (
        <option key={template.title}>{template.title}</option>
      ))}
    </select>
  );
}

/** A letter or an arrow would take the first choice that fits, at once: the list opens, where letters find and Enter takes. */
function openFirst(event: KeyPress<HTMLSelectElement>): void {
  if (event.ctrlKey || event.metaKey || event.altKey || (event.key.length > 1 && !event.key.startsWith("Arrow"))) return;
  event.preventDefault();
  event.currentTarget.showPicker();
}

function Tried(): JSX.Element | null {
  const tried = useSetup((s) => s.probe);
  if (!tried) return null;
  return (
    <div className={`notice${tried.ok ? "" : " bad"}`} role="status" aria-label="Output of the command">
      <div>
        <p>
          {tried.ok ? "✓" : "✗"} <code>{tried.command}</code> after {tried.seconds.toFixed(1)} s
        </p>
        <pre tabIndex={0}>{tried.output}</pre>
      </div>
    </div>
  );
}
