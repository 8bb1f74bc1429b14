// Written by `python -m grip_gui.typescript` from gui/grip_gui/wire/; don't edit.

/** Begin a project with a robot, or complete one. */
export interface BeginRequest {
  robot: string;
  example: string;
  chosen: string[];
}

/** What was written; nothing where there is something to choose first. */
export interface BeginView {
  files: string[];
  findings: string[];
  question: string;
  choices: string[];
}

/** Where runs of a task are to hold. */
export interface Breakpoint {
  node: string;
  when: "before" | "after";
  outcome: string | null;
  condition: string;
}

/** Set the breakpoints of a task; those that aren't named are cleared. */
export interface BreakpointsRequest {
  task: string;
  breakpoints: Breakpoint[];
  page: string;
}

/** Everything that the palette offers. */
export interface CatalogView {
  nodes: NodeFace[];
  tasks: NodeFace[];
  error: string;
}

/** Points that a variable holds, for drawing them in space. */
export interface CloudView {
  frame: string;
  points: string;
  colors: string;
  of: number;
}

/** Try what is configured. */
export interface CommandRequest {
  what: "robot" | "generate" | "test";
  path: string;
  page: string;
}

/** How a try went. */
export interface CommandResult {
  ok: boolean;
  command: string;
  output: string;
  seconds: number;
}

/** What the comment of a node or of the task says in the file; empty for none, None where the node has just gone. */
export interface CommentView {
  revision: number;
  node: string;
  comment: string | null;
}

/** What a component can be tried with. */
export interface ComponentForm {
  name: string;
  inputs: RequestPort[];
  error: string;
}

/** Ask the run under way for something. */
export interface Control {
  command: "pause" | "resume" | "step" | "run_to" | "preempt" | "fault" | "stop";
  how: "tick" | "in" | "over" | "out";
  node: string;
  when: "before" | "after";
  fault: string;
  page: string;
}

/** Take control, or give it back. */
export interface ControlRequest {
  page: string;
  take: boolean;
  over: boolean;
}

/** What a conversion would make of a container. */
export interface ConversionView {
  before: string[];
  after: string[];
  kept: string[];
}

/** A task file that is open for editing. */
export interface DocumentView {
  path: string;
  revision: number;
  text: string;
  saved: boolean;
  draft: boolean;
  change: "" | "changed" | "deleted";
  history: HistoryView;
  layout: LayoutView;
  task: TaskView;
  moved: Record<string, string>;
  checked: boolean;
}

/** How a request went. */
export interface Done {
  error: string;
  said: string;
}

/** Carry out a command that was made on a revision. */
export interface EditRequest {
  path: string;
  base: number;
  command: Record<string, unknown>;
}

/** Body of every refused request. */
export interface ErrorBody {
  detail: string;
  kind: string;
}

/** Server to page: more of a run, in order and without gaps. */
export interface EventsFrame {
  type: "events";
  run: string;
  events: RunEvent[];
  complete: boolean;
}

/** Check an expression where it would stand; nothing is changed. */
export interface ExpressionRequest {
  path: string;
  node: string;
  key: string[];
  text: string;
}

/** A field of an interface. */
export interface FieldView {
  side: string;
  name: string;
  type: string;
}

/** A way to fix a problem with one press. */
export interface FixView {
  title: string;
  command: Record<string, unknown>;
}

/** A folder of the machine that the server runs on. */
export interface FolderView {
  at: string;
  above: string;
  kind: "moveit" | "package" | "folder" | "file";
  entries: Record<string, "moveit" | "package" | "folder" | "file">;
}

/** Whether a container can be edited in both forms, as a tree and as a flow chart. */
export interface FormView {
  path: string;
  both: boolean;
  reason: string;
  edges: [string, string][];
}

/** The forms of all composites and state machines of a task; `error` says why they aren't known. */
export interface FormsView {
  revision: number;
  forms: FormView[];
  error: string;
}

/** A frame on a link. */
export interface FrameView {
  link: string;
  at: number[];
  group: string;
}

/** What the project's robot looks like. */
export interface GeometryView {
  name: string;
  links: Record<string, ShapeView[]>;
  joints: JointView[];
  meshes: MeshView[];
  rest: Record<string, number>;
  grasp: Record<string, FrameView>;
  groups: Record<string, string[]>;
  states: Record<string, Record<string, Record<string, number>>>;
  findings: string[];
  error: string;
}

/** The value of one input: recorded, or typed. */
export interface Given {
  port: string;
  sample: string;
  text: string;
}

/** Where the run holds. */
export interface Held {
  path: string;
  when: "before" | "after";
  why: string;
  outcome: string | null;
  code: string | null;
  message: string | null;
}

/** One state of a document in its history. */
export interface HistoryEntry {
  number: number;
  parent: number | null;
  title: string;
}

/** What can be undone and redone, and the branches. */
export interface HistoryView {
  at: number;
  moments: HistoryEntry[];
  can_undo: boolean;
  can_redo: boolean;
}

/** Import a task: a file that is sent, or what lies on the server's machine. */
export interface ImportRequest {
  source: "smach" | "btcpp" | "pytrees" | "grip";
  name: string;
  text: string;
  path: string;
  execute: boolean;
}

/** What became of it. */
export interface ImportView {
  probe: CommandResult;
  tasks: string[];
}

/** An interface to be wrapped: pasted, the name of an installed type, or a file in its own repository. */
export interface InterfaceRequest {
  text: string;
  type: string;
  file: string;
  outcomes: string;
  failures: string[];
  name: string;
  server: string;
  create: boolean;
}

/** What an interface has, and what keeps it from being a component. */
export interface InterfaceView {
  fields: FieldView[];
  problems: string[];
  suggestion: string;
  text: string;
  path: string;
  output: string;
  type: string;
  server: string;
  script: string;
}

/** Page to server: what people call this page, and what it shows. */
export interface Introduce {
  type: "introduce";
  name: string;
  task: string;
}

/** A joint of a robot. */
export interface JointView {
  name: string;
  type: string;
  parent: string;
  child: string;
  at: number[];
  axis: number[];
  limits: number[];
  mimic: MimicView | null;
}

/** A kind of container: what the page has to know to draw and to edit one. */
export interface KindView {
  kind: string;
  title: string;
  icon: string;
  doc: string;
  holds: "none" | "one" | "many";
  needs_child: boolean;
  edges: boolean;
  concurrent: boolean;
  declares: boolean;
  fields: SettingView[];
  blank: Record<string, unknown>;
}

/** Pinned positions [px], by the path of the node. */
export interface LayoutView {
  flow: Record<string, [number, number]>;
  tree: Record<string, [number, number]>;
}

/** One of them, looked at. */
export interface LiveMessage {
  value: ValueView | null;
  text: string;
  error: string;
}

/** What a running server has. */
export interface LiveMessages {
  served: boolean;
  ours: boolean;
  stores: StoreView[];
  messages: StoredMessage[];
  domain: string;
  error: string;
}

/** Save the robot's current position now as a named message. */
export interface MeasureRequest {
  robot: "run" | "sim" | "fake" | "ros";
  part: string;
  what: "joints" | "pose";
  name: string;
  serve: boolean;
}

/** Triangles, in base64. */
export interface MeshView {
  points: string;
  triangles: string;
}

/** Do something with a running server, or start one. */
export interface MessageRequest {
  do: "serve" | "end" | "delete" | "reset" | "save";
  store: string;
  name: string;
}

/** How a joint follows another one: multiplier * its position + offset. */
export interface MimicView {
  joint: string;
  multiplier: number;
  offset: number;
}

/** What has changed at one time. */
export interface MotionSample {
  t: number;
  q: Record<string, number[]>;
  way: Record<string, number[][]>;
  plans: Record<string, number[][][]>;
  touch: Record<string, Record<string, number>> | null;
  press: Record<string, [string, string, number[], number[]][]> | null;
  scene: Record<string, SceneItem> | null;
}

/** How a run's robot has moved, from some place of the record on. */
export interface MotionView {
  parts: Record<string, string[]>;
  bodies: Record<string, MeshView>;
  samples: MotionSample[];
  next: number;
}

/** A pose, for drawing. */
export interface NamedPlace {
  name: string;
  frame: string;
  at: number[];
}

/** Make a task file. */
export interface NewTask {
  path: string;
  text: string | null;
}

/** A leaf of the catalogue. */
export interface NodeFace {
  id: string;
  doc: string;
  parameters: ParameterFace[];
  inputs: PortFace[];
  outputs: PortFace[];
  outcomes: Record<string, "success" | "failure">;
  codes: string[];
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
  derived: Transition[];
  inputs: Record<string, string>;
  outputs: Record<string, string>;
  parameters: Record<string, unknown>;
  fields: Record<string, unknown>;
}

/** Something about an open task file; as it is, to reload from the file for what is here. */
export interface OfDocument {
  path: string;
}

/** A literal that a leaf takes. */
export interface ParameterFace {
  name: string;
  type: string;
  doc: string;
  required: boolean;
  default: unknown;
}

/** A copy of a node with all below it: what a clipboard holds and `paste` takes. */
export interface Part {
  name: string;
  node: Record<string, unknown>;
  variables: Record<string, unknown>;
}

/** Pin nodes at positions, or let them go (null). */
export interface PinRequest {
  path: string;
  view: "flow" | "tree";
  positions: Record<string, [number, number] | null>;
}

/** Where the nodes stand in the text: path -> 1-based line. */
export interface PlacesView {
  revision: number;
  lines: Record<string, number>;
}

/** An input or an output of a leaf. */
export interface PortFace {
  name: string;
  type: string;
  doc: string;
  required: boolean;
}

/** Something that the validation found, or why a file can't be read. */
export interface Problem {
  path: string;
  code: string;
  severity: "error" | "warning";
  message: string;
  fix: string;
  line: number | null;
  column: number | null;
  key: string[];
  fixes: FixView[];
}

/** What the validation says about a revision. */
export interface ProblemsView {
  revision: number;
  problems: Problem[];
}

/** What the page knows about the project when it opens. */
export interface ProjectView {
  name: string;
  folder: string;
  tasks: TaskEntry[];
  kinds: KindView[];
  robots: string[];
  selected: string | null;
}

/** Add or replace a named message of a running server. */
export interface PutRequest {
  store: string;
  name: string;
  type: string;
  text: string;
}

/** Wait for one message of a topic. */
export interface ReceiveRequest {
  topic: string;
  type: string;
  within: number;
}

/** One message, looked at. */
export interface ReceivedView {
  value: ValueView | null;
  seconds: number;
  error: string;
}

/** Keep a value of a run as a named message of the project. */
export interface RecordRequest {
  run: string;
  seq: number;
  name: string;
}

/** Server to page: a message that wasn't understood. */
export interface RefusedFrame {
  type: "refused";
  reason: string;
}

/** An input of a component. */
export interface RequestPort {
  name: string;
  type: string;
  doc: string;
  samples: Sample[];
}

/** Server to page: the revision of each open task file. */
export interface RevisionsFrame {
  type: "revisions";
  revisions: Record<string, number>;
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

/** What a run is started with. */
export interface RunOptions {
  robot: "sim" | "fake" | "ros";
  target: "bt" | "sm";
  seed: number;
  pace: number | null;
  mocks: Record<string, string>;
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

/** A value that was recorded, as an input of a component. */
export interface Sample {
  source: string;
  title: string;
  type: string;
}

/** Save a file. */
export interface SaveRequest {
  path: string;
  over: boolean;
}

/** An object of the planning scene. */
export interface SceneItem {
  kind: "box" | "cylinder" | "sphere" | "mesh" | "cells";
  size: number[];
  body: string;
  at: number[];
  hand: string;
  fixed: boolean;
}

/** What is selected on a page. */
export interface Selected {
  task: string;
  nodes: string[];
}

/** Page to server: the nodes that are selected on it; a page sends it when that changes. */
export interface Selection {
  task: string;
  nodes: string[];
  type: "selection";
}

/** Server to page: what other pages have selected, of those alone where it has changed. */
export interface SelectionsFrame {
  type: "selections";
  selections: Record<string, Selected | null>;
}

export type ServerFrame = SessionFrame | SharedStateFrame | EventsFrame | RefusedFrame | RevisionsFrame | SelectionsFrame;

/** Server to page: how the run under way is; None when none was started. */
export interface SessionFrame {
  type: "session";
  session: SessionView | null;
}

/** The run that this server started last, and how its process is. */
export interface SessionView {
  robot: "sim" | "fake" | "ros";
  target: "bt" | "sm";
  seed: number;
  pace: number | null;
  mocks: Record<string, string>;
  state: "starting" | "running" | "paused" | "stopping" | "ended";
  task: string;
  run: string | null;
  held: Held | null;
  status: string | null;
  outcome: string | null;
  message: string;
  contradiction: string;
  zombies: string[];
  rest: string;
  unconfirmed: string[];
}

/** A setting of a container. */
export interface SettingView {
  key: string;
  type: "bool" | "int" | "float" | "choice" | "text" | "expression" | "variable" | "child" | "cases" | "json";
  doc: string;
  required: boolean;
  default: unknown;
  choices: string[];
}

/** One value of the form, to be put into the text; nothing is written. */
export interface SetupChange {
  path: string;
  text: string;
  do: "set" | "remove" | "rename";
  key: (string | number)[];
  value: unknown;
}

/** A file of the project that is no task. */
export interface SetupEntry {
  path: string;
  kind: string;
  title: string;
  exists: boolean;
  doc: string;
}

/** Write a settings file. */
export interface SetupSave {
  path: string;
  text: string;
  known: string;
  over: boolean;
}

/** A text of a settings file, to be looked at; nothing is written. */
export interface SetupText {
  path: string;
  text: string;
}

/** A settings file as text, as data, and what is wrong with it. */
export interface SetupView {
  path: string;
  kind: string;
  title: string;
  text: string;
  known: string;
  data: unknown;
  shape: Record<string, unknown>;
  options: Record<string, string[]>;
  templates: Template[];
  problems: Problem[];
}

/** A body of a link. */
export interface ShapeView {
  kind: "box" | "cylinder" | "sphere" | "mesh";
  size: number[];
  at: number[];
  color: number[];
  mesh: number;
}

/** What all pages share: who looks on, who holds control, and where runs hold. */
export interface SharedState {
  holder: string | null;
  connections: number;
  viewers: Viewer[];
  breakpoints: Record<string, Breakpoint[]>;
}

/** Server to page: who holds control, and where runs hold. */
export interface SharedStateFrame {
  type: "desk";
  desk: SharedState;
}

/** Start a run of a task. */
export interface StartRun {
  robot: "sim" | "fake" | "ros";
  target: "bt" | "sm";
  seed: number;
  pace: number | null;
  mocks: Record<string, string>;
  task: string;
  begin_at: string;
  run_to: string;
  page: string;
}

/** Undo, redo, or go to a moment of any branch. */
export interface StepRequest {
  path: string;
  base: number;
  step: "undo" | "redo" | "go";
  number: number | null;
}

/** A store of a running server. */
export interface StoreView {
  name: string;
  type: string;
  queued: number;
}

/** A named message of a running server. */
export interface StoredMessage {
  store: string;
  name: string;
  type: string;
  time: number;
  provenance: string;
  revision: number;
}

/** How long something had the focus on a page; reading is what is done away from it. */
export interface StudySpan {
  window: "configure" | "program" | "run" | "away";
  seconds: number;
  page: string;
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

/** Something to begin with. */
export interface Template {
  title: string;
  key: string[];
  value: unknown;
}

/** Take a text that was typed on a revision; what `over` replaces comes back by undo. */
export interface TextRequest {
  path: string;
  over: boolean;
  base: number;
  text: string;
}

/** A topic that somebody publishes. */
export interface TopicView {
  name: string;
  type: string;
  value: string;
  publishers: number;
}

/** The topics of the running graph. */
export interface TopicsView {
  topics: TopicView[];
  domain: string;
  error: string;
}

/** An edge of a state machine, or of the root: what happens after one outcome of a node. */
export interface Transition {
  outcome: string;
  target: string;
  ends: boolean;
}

/** Call a component once. */
export interface TryRequest {
  path: string;
  given: Given[];
}

/** How a component answered. */
export interface TryView {
  outcome: string;
  fields: Record<string, ValueView>;
  milliseconds: number;
  started: string;
  error: string;
}

/** What was written to a variable, for looking at. */
export interface ValueView {
  type: string;
  text: string;
  rows: string[][];
  picture: string;
  caption: string;
  places: NamedPlace[];
}

/** A variable that the task declares. */
export interface VariableView {
  scope: string;
  name: string;
  type: string;
  doc: string;
  initial: string | null;
  whole: boolean;
  ports: ("input" | "output")[];
}

/** A page that looks on. */
export interface Viewer {
  page: string;
  name: string;
  colour: number;
  task: string;
}
