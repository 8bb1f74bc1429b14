/** What is shown, what is run and how; the buttons of the run are beside it, or below where there is less room. */
import { type JSX, type KeyboardEvent, type ReactNode, useEffect } from "react";

import { runText } from "../model/words";
import type { Control, ProjectView } from "../protocol/generated";
import { actionTitle } from "../store/actions";
import { chooseTask } from "../store/desk";
import { type Room, usePage } from "../store/page";
import { type Pane, usePanes } from "../store/panes";
import { useRun } from "../store/run";
import { type RunOptions as Options, useRunning } from "../store/runDesk";
import { control, start, step, stop } from "../store/running";
import { newTask } from "../store/tasks";
import { Presence } from "./Presence";

const ROOMS: readonly [Room, string][] = [
  ["task", "Tasks"],
  ["project", "Project"],
];
/** Simulated seconds in a second; 0 stands for no limit. */
const PACES = [0.25, 0.5, 1, 2, 5, 0];

/** @param begins whether the project only begins: there is nothing to choose among, and nothing to put away. */
export function TopBar({ project, begins }: { project: ProjectView; begins: boolean }): JSX.Element {
  const task = useRun((s) => s.task);
  const session = useRun((s) => s.session);
  const options = useRunning((s) => s.options);
  const { setOptions } = useRunning.getState();
  const room = usePage((s) => s.room);
  const state = session?.state ?? "ended";
  // What runs, also when another page or the command line started it, is what the fields say.
  const started = session?.state === "starting" || session?.state === "running" ? session : null;
  useEffect(() => {
    if (started) setOptions({ robot: started.robot, target: started.target, seed: started.seed, pace: started.pace });
  }, [started, setOptions]);
  const under_way = state !== "ended";
  const change = (part: Partial<Options>): void => setOptions({ ...options, ...part });

  return (
    <header className="bar">
      <div className="bar-part">
        <span className="brand">
          <Mark />
          <h1 title={project.folder}>
            GRIP <small>{project.name}</small>
          </h1>
        </span>
        <div className="segments" role="group" aria-label="What is shown">
          {ROOMS.map(([name, label]) => (
            <button key={name} aria-pressed={room === name} onClick={() => usePage.getState().setRoom(name)}>
              {label}
            </button>
          ))}
        </div>
        {!begins && (project.tasks.length > 0 || task.path !== "") && <Field label="Task">
          <select id="task-field" value={task.path} onChange={(event) => void chooseTask(event.target.value)}>
            {project.tasks.some((entry) => entry.path === task.path) || <option value={task.path}>{task.path}</option>}
            {project.tasks.map((entry) => (
              <option key={entry.path} value={entry.path}>
                {entry.path.replace(/^tasks\//, "").replace(/\.ya?ml$/, "")}
              </option>
            ))}
          </select>
        </Field>}
        <button aria-label="New task" title="New task" onClick={() => void newTask()}>
          <Picture shape="M8 3v10M3 8h10" />
        </button>
        <RunOptionFields project={project} options={options} change={change} disabled={under_way} />
      </div>
      <RunBar />
      {room === "task" && !begins && <PaneButtons />}
    </header>
  );
}

const hold = (event: { preventDefault(): void; key?: string }): void => {
  if (event.key !== "Tab" && event.key !== "Escape") event.preventDefault();
};
/** What a run was started with stays as it is; a field that has the focus then keeps it. */
const UNDER_WAY = { "aria-disabled": true, onMouseDown: hold, onKeyDown: hold } as const;

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
          {...(disabled ? UNDER_WAY : {})}
          onChange={(event) => change({ robot: event.target.value as Options["robot"] })}
        >
          {project.robots.map((robot) => (
            <option key={robot}>{robot}</option>
          ))}
        </select>
      </Field>
      <details className="more" onKeyDown={closeOnEscape}>
        <summary title="How it runs: as a tree or a machine, how fast, with which seed">
          {[options.target === "sm" && "machine", options.pace !== 1 && (options.pace === null ? "no limit" : `${options.pace}x`), options.seed !== 0 && `seed ${options.seed}`].filter(Boolean).join(", ") || "Options"}
        </summary>
        <div className="more-list">
      <Field label="As">
        <select id="as-field"
          value={options.target}
          {...(disabled ? UNDER_WAY : {})}
          onChange={(event) => change({ target: event.target.value as Options["target"] })}
        >
          <option value="bt">tree</option>
          <option value="sm">machine</option>
        </select>
      </Field>
      <Field label="Pace">
        <select id="pace-field"
          value={options.pace ?? 0}
          {...(disabled ? UNDER_WAY : {})}
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
          readOnly={disabled}
          {...(disabled ? UNDER_WAY : {})}
          onChange={(event) => change({ seed: Math.max(0, Math.floor(Number(event.target.value) || 0)) })}
        />
      </Field>
        </div>
      </details>
    </>
  );
}

/** Close a list of further things with the key that closes everything. */
export function closeOnEscape(event: KeyboardEvent<HTMLDetailsElement>): void {
  if (event.key !== "Escape" || !event.currentTarget.open) return;
  event.currentTarget.open = false;
  event.currentTarget.querySelector("summary")?.focus();
  event.stopPropagation();
}

const PANES: readonly [Pane, string, string][] = [
  ["left", "Outline and palette", "M2.5 3h11v10h-11zM6 3v10"],
  ["foot", "Below the views", "M2.5 3h11v10h-11zM2.5 9.5h11"],
  ["right", "Forms", "M2.5 3h11v10h-11zM10 3v10"],
];

function PaneButtons(): JSX.Element {
  const { hidden, toggle } = usePanes();
  return (
    <span className="segments panes" role="group" aria-label="Panes">
      {PANES.map(([pane, label, shape]) => (
        <button key={pane} aria-pressed={!hidden.has(pane)} aria-label={label} title={actionTitle(pane)} onClick={() => toggle(pane)}>
          <Picture shape={shape} />
        </button>
      ))}
    </span>
  );
}

function Picture({ shape }: { shape: string }): JSX.Element {
  return (
    <svg className="icon" viewBox="0 0 16 16" aria-hidden="true">
      <path d={shape} />
    </svg>
  );
}

/** How a run stands, or ended, as the style sheet calls it. */
function useStateName(): string {
  const session = useRun((s) => s.session);
  const connected = useRun((s) => s.connected);
  const status = session?.contradiction ? "failure" : session?.status;
  return `state-${connected === false ? "lost" : session?.state === "ended" ? `ended-${status}` : (session?.state ?? "none")}`;
}

/** A hand over a node. */
function Mark(): JSX.Element {
  return (
    <svg className={`mark ${useStateName()}`} viewBox="0 0 24 24" aria-hidden="true">
      <path d="M12 2v4M6.500 6h11" />
      <path className="finger one" d="M6.500 6 4.500 11l3 6.500" />
      <path className="finger other" d="M17.500 6l2 5-3 6.500" />
      <circle cx="12" cy="16" r="4.200" />
    </svg>
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

export function RunBar(): JSX.Element {
  const state = useRun((s) => s.session?.state ?? "ended");
  const empty = useRun((s) => s.task.nodes.length === 0);
  const broken = useRun((s) => s.task.problems.some((problem) => problem.severity === "error"));
  const paused = state === "paused";
  return (
    <div className="bar-part run-part">
      <div className="buttons">
        <button className="run" disabled={broken || empty} {...(state === "ended" ? {} : { "aria-disabled": true })} title={broken ? "The task has errors; see Problems" : actionTitle("run")} onClick={() => state === "ended" && void start()}>
          Run
        </button>
        <button className="pause" disabled={!paused && state !== "running"} title={actionTitle("pause")} onClick={() => void control(paused ? "resume" : "pause")}>
          {paused ? "Resume" : "Pause"}
        </button>
        <Stop />
      </div>
      {paused && <Steps />}
      <Presence />
      <RunState />
    </div>
  );
}

/** Dead where it can't reach anything: who relies on it has to see that. */
function Stop(): JSX.Element {
  const dead = useRun((s) => s.connected === false);
  if (dead) {
    return (
      <button className="stop dead" disabled title="No connection to the server: nothing is stopped from here. Use the robot's own stop.">
        <s>STOP</s> <span className="hidden">is dead: no connection to the server</span>
      </button>
    );
  }
  return (
    <button className="stop" aria-keyshortcuts="F8" title="Stop the run at once (F8)" onClick={stop}>
      STOP
    </button>
  );
}

const STEPS: readonly [Control["how"], string, string, string][] = [
  ["over", "Step over", "over", "M2 9a6 5 0 0 1 11-2M13 3v4H9M8 12.5h.1"],
  ["in", "Step in", "into", "M8 2v8M4.5 6.5 8 10l3.5-3.5M8 13.5h.1"],
  ["out", "Step out", "step-out", "M8 10V2M4.5 5.5 8 2l3.5 3.5M8 13.5h.1"],
  ["tick", "Step", "tick", "M3 8h7M7 4.5 10.5 8 7 11.5M13 4v8"],
];

function Steps(): JSX.Element {
  return (
    <span className="buttons steps" role="group" aria-label="Steps of a paused run">
      {STEPS.map(([how, label, action, shape]) => (
        <button key={how} aria-label={label} title={actionTitle(action)} onClick={() => step(how)}>
          <Picture shape={shape} />
        </button>
      ))}
    </span>
  );
}

/** The state of the process, with the time that it has been so while it starts. STOP by key works wherever the focus is. */
function RunState(): JSX.Element {
  const session = useRun((s) => s.session);
  const connected = useRun((s) => s.connected);
  useEffect(() => {
    const onKey = (event: globalThis.KeyboardEvent): void => {
      if (event.key === "F8") {
        event.preventDefault();
        stop();
      }
    };
    window.addEventListener("keydown", onKey, { capture: true });
    return () => window.removeEventListener("keydown", onKey, { capture: true });
  }, []);
  const words = connected ? runText(session) : connected === null ? "connecting ..." : "no connection to the server";
  return (
    <output className={`run-state ${useStateName()}`} aria-live="polite" aria-label="State of the run" title={words}>
      {words}
    </output>
  );
}
