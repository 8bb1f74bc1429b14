/** Where an empty project begins: a robot, a task from elsewhere, or an example; and what the project then has. */
import "../setup/setup.css";
import { type JSX, lazy, type ReactNode, Suspense, useEffect, useState } from "react";
import { firstTask } from "../../model/parts";
import { matching } from "../../model/commands";
import { server } from "../../protocol/client";
import type { GeometryView } from "../../protocol/generated";
import { begin, goOn, leaveBeginning, openExample, openFirst, useBegin } from "../../store/begin";
import { loadGeometry, useRobot } from "../../store/live";
import { newTask, useProject } from "../../store/tasks";
import { ImportForm } from "../setup/ImportForm";
import { ProjectParts } from "../setup/ProjectParts";
import FileBrowser, { type Entry } from "./FileBrowser";

const RobotPreview = lazy(() => import("../robot/RobotPreview"));

type Door = "robot" | "task" | "example";
const DOORS: readonly [Door, string, string, string][] = [
  ["robot", "Take a robot", "A ready-made arm with a hand, or your own: MoveIt package, launch file, URDF or xacro. It comes with a world and a task in which the hand holds a thing.", "M3 14h6M6 14V9l5-4M11 5l3 1M11 5V2M6 9a1 1 0 1 0 0-2 1 1 0 0 0 0 2"],
  ["task", "Bring a task", "From SMACH, BehaviorTree.CPP, py_trees, or the first GRIP.", "M2 9v5h12V9M8 2v8M5 7l3 3 3-3"],
  ["example", "Open an example", "Tasks that run: clear a table, fill a shelf, take turns.", "M3 2h8l2 2v10H3zM6 7h4M6 10h4"],
];

export default function StartPage(): JSX.Element {
  const [door, setDoor] = useState<Door | null>(useBegin.getState().choosing ? "robot" : null);
  const made = useBegin((s) => s.made);
  const busy = useBegin((s) => s.busy);
  const error = useBegin((s) => s.error);
  const choosing = useBegin((s) => s.choosing);
  return (
    <main className={`start${door === null && !made ? " start-closed" : ""}`} aria-label="Begin">
      <h2 className={door === null && !made ? "" : "hidden"}>{choosing ? "Another robot" : "How shall this project begin?"}</h2>
      {!choosing && !made && <div className="start-doors" role="group" aria-label="How to begin">
        {DOORS.map(([name, title, doc, shape]) => (
          <button key={name} className="door" aria-pressed={door === name} disabled={busy !== ""} onClick={() => setDoor(name)}>
            <svg className="icon" viewBox="0 0 16 16" aria-hidden="true">
              <path d={shape} />
            </svg>
            <strong>{title}</strong>
            <span>{doc}</span>
          </button>
        ))}
      </div>}
      <p className="hint start-else">
        {made ? null : choosing ? <button className="link" onClick={leaveBeginning}>Back, and leave the robot as it is</button> : <>Or begin with nothing: <button className="link" onClick={() => void newTask()}>an empty task</button></>}
      </p>
      {busy && <p className="notice" role="status">{busy}</p>}
      {error && <p className="notice bad" role="alert">{error}</p>}
      {made ? <Made /> : door === "robot" ? <RobotDoor /> : door === "task" ? <TaskDoor /> : door === "example" ? <ExampleDoor /> : null}
    </main>
  );
}

/** What has been written, what still lacks, and the way on. */
function Made(): JSX.Element {
  const made = useBegin((s) => s.made);
  const wanted = useBegin((s) => s.wanted);
  const project = useProject((s) => s.project);
  const view = useRobot((s) => s.view);
  useEffect(() => void loadGeometry(), []);
  const first = firstTask(project?.tasks.map((task) => task.path) ?? []);
  return (
    <section className="start-made" aria-labelledby="made-title">
      <h2 id="made-title">The project is there</h2>
      <div className="start-has">
        <div>
          <ProjectParts />
          {wanted !== null && (
            <p className="start-on">
              <button className="main start-go" autoFocus onClick={() => void goOn(wanted.node)}>
                Go on, and add {wanted.node}
              </button>
            </p>
          )}
          {first !== undefined && wanted === null && (
            <p className="start-on">
              <button className="main start-go" autoFocus onClick={() => void openFirst(first)}>
                Open the first task
              </button>
              <span className="hint">then press Run: {first === "tasks/take.yaml" ? "the hand takes a thing from the bench and holds it" : "the robot moves through its states"}</span>
            </p>
          )}
        </div>
        <Suspense fallback={<p className="hint loading">Loading the 3D view ...</p>}>
          <RobotPreview view={view} moves />
        </Suspense>
      </div>
      {made !== null && made.findings.length > 0 && (
        <details>
          <summary>
            What the robot's files said <span className="hint">{made.findings.length}</span>
          </summary>
          <ul aria-label="What the robot's files said">
            {made.findings.map((finding) => (
              <li key={finding}>{finding}</li>
            ))}
          </ul>
        </details>
      )}
    </section>
  );
}

const TAKES = /\.(urdf|xacro|xml|launch|launch\.py|launch\.yaml)$/;
const takesRobot = (entry: Entry): boolean => (entry.kind === "file" ? TAKES.test(entry.name) && entry.name !== "package.xml" && !entry.name.includes(".srdf") : entry.kind !== "folder");

function RobotDoor(): JSX.Element {
  const [robots, setRobots] = useState<Readonly<Record<string, string>>>({});
  const [text, setText] = useState("");
  const [own, setOwn] = useState(false);
  const [chosen, setChosen] = useState("");
  const [view, setView] = useState<GeometryView | null>(null);
  const busy = useBegin((s) => s.busy !== "");
  const [hands, setHands] = useState<ReadonlySet<string>>(new Set());
  useEffect(() => void server.robots().then(setRobots, () => setOwn(true)), []);
  useEffect(() => void server.pairs().then((pairs) => setHands(new Set(Object.values(pairs).map((pair) => pair.hand))), () => undefined), []);
  useEffect(() => {
    if (chosen === "") return;
    let left = false;
    setView(null);
    const nothing = { name: "", links: {}, joints: [], meshes: [], rest: {}, grasp: {}, groups: {}, states: {}, findings: [] };
    server.geometry(chosen).then((found) => left || setView(found), (why: unknown) => left || setView({ ...nothing, error: why instanceof Error ? why.message : String(why) }));
    return () => {
      left = true;
    };
  }, [chosen]);
  const options = Object.entries(robots).map(([name, doc]) => ({ value: name, label: name, detail: doc }));
  options.sort((one, other) => Number(hands.has(one.value)) - Number(hands.has(other.value))); // a hand alone begins no task
  const name = chosen.split("/").at(-1) ?? "";
  return (
    <section className="start-room" aria-label="Robots">
      <div className="start-list">
        <div className="segments" role="group" aria-label="Where the robot is from">
          <button aria-pressed={!own} onClick={() => setOwn(false)}>Ready-made</button>
          <button aria-pressed={own} onClick={() => setOwn(true)}>My files ...</button>
        </div>
        {own ? (
          <FileBrowser fits={takesRobot} chosen={chosen} choose={setChosen} />
        ) : (
          <>
            <input type="search" aria-label="Search the robots" placeholder="Type to find a robot" value={text} onChange={(event) => setText(event.target.value)} />
            <ul className="plain scroll" tabIndex={0} aria-label="Ready-made robots">
              {matching(options, text).map((robot) => (
                <li key={robot.value}>
                  <button className="setup-file" aria-pressed={chosen === robot.value} onClick={() => setChosen(robot.value)} onDoubleClick={() => void begin(robot.value)}>
                    <strong>{robot.label}</strong>
                    <span className="hint">{robot.detail}</span>
                  </button>
                </li>
              ))}
            </ul>
          </>
        )}
      </div>
      <div className="start-look">
        {chosen === "" ? (
          <p className="hint loading">Choose a robot on the left to look at it.</p>
        ) : (
          <>
            <Suspense fallback={<p className="hint loading">Loading the 3D view ...</p>}>
              <RobotPreview view={view} />
            </Suspense>
            <p className="start-take">
              <button className="main start-go" disabled={busy} onClick={() => void begin(chosen)}>
                Take {name}
              </button>
              <span className="hint">{options.find((robot) => robot.value === chosen)?.detail ?? chosen}</span>
            </p>
          </>
        )}
      </div>
    </section>
  );
}

function TaskDoor(): JSX.Element {
  return (
    <Room label="Tasks from elsewhere">
      <ImportForm />
    </Room>
  );
}

function ExampleDoor(): JSX.Element {
  const [examples, setExamples] = useState<Readonly<Record<string, string>>>({});
  const busy = useBegin((s) => s.busy !== "");
  useEffect(() => void server.examples().then(setExamples, () => setExamples({})), []);
  return (
    <Room label="Examples">
      <p className="hint">The example project is copied into this folder; it is yours to change. A Panda arm with an Allegro hand at a table.</p>
      <ul className="plain start-examples" aria-label="Tasks of the example">
        {Object.entries(examples).map(([task, doc]) => (
          <li key={task}>
            <button className="setup-file" disabled={busy} onClick={() => void openExample(task)}>
              <strong>{task.replaceAll("_", " ")}</strong>
              <span className="hint">{doc}</span>
            </button>
          </li>
        ))}
      </ul>
    </Room>
  );
}

function Room({ label, children }: { label: string; children: ReactNode }): JSX.Element {
  return (
    <section className="start-page scroll" aria-label={label}>
      <h2 className="hidden">{label}</h2>
      {children}
    </section>
  );
}
