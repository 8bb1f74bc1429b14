// Written by `python -m grip_gui.typescript` from gui/grip_gui/messages.py; don't edit.

/** Ask the run under way for something. */
export interface Control {
  command: "pause" | "resume" | "step" | "stop";
}

/** Server to page: more of a run, in order and without gaps. */
export interface EventsFrame {
  type: "events";
  run: string;
  events: RunEvent[];
  complete: boolean;
}

/** One node of a task. */
export interface NodeView {
  path: string;
  parent: string | null;
  name: string;
  kind: string;
  label: string;
  doc: string;
  children: string[];
  outcomes: Record<string, "success" | "failure">;
  initial: boolean;
  on: Transition[];
  inputs: Record<string, string>;
  outputs: Record<string, string>;
  parameters: Record<string, unknown>;
}

/** Something that the validation found, or why a file can't be read. */
export interface Problem {
  path: string;
  code: string;
  severity: "error" | "warning";
  message: string;
  fix: string;
  line: number | null;
}

/** What the page knows about the project when it opens. */
export interface ProjectView {
  name: string;
  folder: string;
  tasks: TaskEntry[];
  robots: string[];
  selected: string | null;
}

/** Server to page: a message that wasn't understood. */
export interface RefusedFrame {
  type: "refused";
  reason: string;
}

/** One line of the journal. */
export interface RunEvent {
  seq: number;
  t: number;
  path: string;
  event: string;
  outcome: string | null;
  code: string | null;
  data: Record<string, unknown>;
}

/** A run of the journal. */
export interface RunRecord {
  id: string;
  task_name: string;
  task_path: string;
  target: string;
  seed: number | null;
  started: number;
  ended: number | null;
  status: string;
  outcome: string | null;
}

/** A run with the task as it was when it ran. */
export interface RunView {
  run: RunRecord;
  task: TaskView;
}

export type ServerFrame = SessionFrame | EventsFrame | RefusedFrame;

/** Server to page: how the run under way is; None when none was started. */
export interface SessionFrame {
  type: "session";
  session: SessionView | null;
}

/** The run that this server started last, and how its process is. */
export interface SessionView {
  state: "starting" | "running" | "paused" | "stopping" | "ended";
  task: string;
  robot: "sim" | "fake";
  target: "bt" | "sm";
  seed: number;
  pace: number | null;
  run: string | null;
  status: string | null;
  outcome: string | null;
  message: string;
}

/** Start a run of a task. */
export interface StartRun {
  task: string;
  robot: "sim" | "fake";
  target: "bt" | "sm";
  seed: number;
  pace: number | null;
}

/** Page to server: send this run's events from `from_seq` on. */
export interface Subscribe {
  type: "subscribe";
  run: string;
  from_seq: number;
}

/** A task file of the project. */
export interface TaskEntry {
  path: string;
  name: string;
}

/** A task file. `nodes` is empty when the text can't be read as a task; `problems` then says why. */
export interface TaskView {
  path: string;
  name: string;
  doc: string;
  outcomes: Record<string, "success" | "failure">;
  nodes: NodeView[];
  variables: VariableView[];
  problems: Problem[];
}

/** An edge of a state machine, or of the root: what happens after one outcome of a node. */
export interface Transition {
  outcome: string;
  target: string;
  ends: boolean;
}

/** Body of every refused request. */
export interface Trouble {
  detail: string;
}

/** A variable that the task declares. */
export interface VariableView {
  scope: string;
  name: string;
  type: string;
  doc: string;
  initial: string | null;
}
