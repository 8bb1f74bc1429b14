/** What is run, how, and the buttons. STOP is always there and always answers. */
import { type JSX, type ReactNode, useEffect, useState } from "react";

import { runText } from "../model/words";
import type { ProjectView, StartRun } from "../protocol/generated";
import { chooseTask, control, startRun } from "../store/desk";
import { useRun } from "../store/run";
import { newTask } from "../store/tasks";

type Options = Omit<StartRun, "task">;

/** Simulated seconds in a second; 0 stands for no limit. */
const PACES = [0.25, 0.5, 1, 2, 5, 0];

export function TopBar({ project }: { project: ProjectView }): JSX.Element {
  const task = useRun((s) => s.task);
  const session = useRun((s) => s.session);
  const broken = task.problems.some((problem) => problem.severity === "error");
  const [options, setOptions] = useState<Options>({ robot: "sim", target: "bt", seed: 0, pace: 1 });
  const state = session?.state ?? "ended";
  // What runs, also when another page or the command line started it, is what the fields say.
  const started = session?.state === "starting" || session?.state === "running" ? session : null;
  useEffect(() => {
    if (started) setOptions({ robot: started.robot, target: started.target, seed: started.seed, pace: started.pace });
  }, [started]);
  const under_way = state !== "ended";
  const change = (part: Partial<Options>): void => setOptions({ ...options, ...part });

  return (
    <header className="bar">
      <h1 title={project.folder}>
        GRIP <small>{project.name}</small>
      </h1>
      <Field label="Task">
        <select id="task-field" value={task.path} onChange={(event) => void chooseTask(event.target.value)}>
          {project.tasks.some((entry) => entry.path === task.path) || <option value={task.path}>{task.path}</option>}
          {project.tasks.map((entry) => (
            <option key={entry.path} value={entry.path}>
              {entry.path.replace(/^tasks\//, "").replace(/\.ya?ml$/, "")}
            </option>
          ))}
        </select>
      </Field>
      <button onClick={() => void newTask()}>New task</button>
      <RunOptionFields project={project} options={options} change={change} disabled={under_way} />
      <div className="buttons">
        <button
          className="run"
          disabled={under_way || broken || task.nodes.length === 0}
          title={broken ? "The task has errors; see Problems" : "Run the task in a process of its own"}
          onClick={() => void startRun({ task: task.path, ...options })}
        >
          Run
        </button>
        {state === "paused" ? (
          <button onClick={() => void control("resume")}>Resume</button>
        ) : (
          <button disabled={state !== "running"} onClick={() => void control("pause")}>
            Pause
          </button>
        )}
        <button disabled={state !== "paused"} title="One tick" onClick={() => void control("step")}>
          Step
        </button>
        <button className="stop" aria-keyshortcuts="F8" title="Stop the run at once (F8)" onClick={stop}>
          STOP
        </button>
      </div>
      <RunState />
    </header>
  );
}

function RunOptionFields(props: {
  project: ProjectView;
  options: Options;
  change: (part: Partial<Options>) => void;
  disabled: boolean;
}): JSX.Element {
  const { project, options, change, disabled } = props;
  return (
    <>
      <Field label="Robot">
        <select id="robot-field"
          value={options.robot}
          disabled={disabled}
          onChange={(event) => change({ robot: event.target.value as Options["robot"] })}
        >
          {project.robots.map((robot) => (
            <option key={robot}>{robot}</option>
          ))}
        </select>
      </Field>
      <Field label="As">
        <select id="as-field"
          value={options.target}
          disabled={disabled}
          onChange={(event) => change({ target: event.target.value as Options["target"] })}
        >
          <option value="bt">tree</option>
          <option value="sm">machine</option>
        </select>
      </Field>
      <Field label="Pace">
        <select id="pace-field"
          value={options.pace ?? 0}
          disabled={disabled}
          title="Simulated seconds in a second"
          onChange={(event) => change({ pace: Number(event.target.value) || null })}
        >
          {PACES.map((pace) => (
            <option key={pace} value={pace}>
              {pace === 0 ? "no limit" : `${pace}x`}
            </option>
          ))}
        </select>
      </Field>
      <Field label="Seed">
        <input id="seed-field"
          type="number"
          min={0}
          max={2147483647}
          value={options.seed}
          disabled={disabled}
          onChange={(event) => change({ seed: Math.max(0, Math.floor(Number(event.target.value) || 0)) })}
        />
      </Field>
    </>
  );
}

/** A label and its field side by side; the field's id is `<label>-field`. */
function Field({ label, children }: { label: string; children: ReactNode }): JSX.Element {
  return (
    <span className="field">
      <label htmlFor={`${label.toLowerCase()}-field`}>{label}</label>
      {children}
    </span>
  );
}

function stop(): void {
  const { session } = useRun.getState();
  if (session && session.state !== "ended") void control("stop");
}

/** The state of the process, with the time that it has been so while it starts. STOP by key works wherever the focus is. */
function RunState(): JSX.Element {
  const session = useRun((s) => s.session);
  const connected = useRun((s) => s.connected);
  useEffect(() => {
    const onKey = (event: KeyboardEvent): void => {
      if (event.key === "F8") {
        event.preventDefault();
        stop();
      }
    };
    window.addEventListener("keydown", onKey, { capture: true });
    return () => window.removeEventListener("keydown", onKey, { capture: true });
  }, []);
  const words = connected ? runText(session) : "no connection to the server";
  const kind = !connected ? "lost" : session?.state === "ended" ? `ended-${session.status}` : (session?.state ?? "none");
  return (
    <output className={`run-state state-${kind}`} aria-live="polite" aria-label="State of the run">
      {words}
    </output>
  );
}
