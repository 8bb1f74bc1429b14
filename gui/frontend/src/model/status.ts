/** What a node looks like at one moment of a run, and the one place that turns events into it. */
import type { NodeView, RunEvent, TaskView } from "../protocol/generated";

export type Phase = "idle" | "running" | "success" | "failure" | "ended" | "interrupted" | "error";

export interface NodeStatus {
  readonly phase: Phase;
  /** When it entered this phase [s after the start]. */
  readonly since: number;
  readonly outcome?: string | undefined;
  readonly code?: string | undefined;
  /** Why it failed, or what it says about its work. */
  readonly message?: string | undefined;
  /** How often it was started since its parent was. */
  readonly activations: number;
}

export interface VariableValue {
  readonly type: string;
  readonly preview: string;
  readonly writer: string;
  readonly t: number;
  /** Number of the event, by which the whole value is asked for. */
  readonly seq: number;
}

export interface RunFacts {
  readonly state: string;
  readonly status?: string | undefined;
  readonly outcome?: string | undefined;
  readonly error?: { readonly path: string; readonly type: string; readonly message: string; readonly traceback: string } | undefined;
}

export const IDLE: NodeStatus = { phase: "idle", since: 0, activations: 0 };

/** All that is shown about one moment. Values are replaced, never changed, so that views compare by identity. */
export class Moment {
  constructor(
    readonly nodes: Map<string, NodeStatus> = new Map(),
    readonly variables: Map<string, VariableValue> = new Map(),
    public facts: RunFacts = { state: "running" },
    public t: number = 0,
    /** What ran when the run's process died: it runs on when somebody goes on with the run. */
    public cut: ReadonlyMap<string, NodeStatus> = new Map(),
  ) {}

  copy(): Moment {
    return new Moment(new Map(this.nodes), new Map(this.variables), this.facts, this.t, this.cut);
  }

  status(path: string): NodeStatus {
    return this.nodes.get(path) ?? IDLE;
  }
}

/** What the reducer must know about the task: meanings of outcomes, parents, scopes of variables. */
export class TaskIndex {
  readonly byPath: ReadonlyMap<string, NodeView>;
  /** The worst that the validation says about a node. */
  readonly worst: ReadonlyMap<string, "error" | "warning">;
  private readonly scopes: ReadonlySet<string>;

  constructor(readonly task: TaskView) {
    this.byPath = new Map(task.nodes.map((node) => [node.path, node]));
    const worst = new Map<string, "error" | "warning">();
    for (const { path, severity } of task.problems) if (worst.get(path) !== "error") worst.set(path, severity);
    this.worst = worst;
    this.scopes = new Set(task.variables.map((v) => variableKey(v.scope, v.name)));
  }

  phaseOf(path: string, outcome: string | null): Phase {
    const meaning = outcome === null ? undefined : this.byPath.get(path)?.outcomes[outcome];
    if (meaning) return meaning;
    return outcome === "success" || outcome === "failure" ? outcome : "ended";
  }

  /** Key of the variable that a node at `path` means by `name`: the nearest declaration above it. */
  variable(path: string, name: string): string {
    let at: string | null = path;
    while (at !== null) {
      const key = variableKey(at, name);
      if (this.scopes.has(key)) return key;
      at = this.byPath.get(at)?.parent ?? null;
    }
    return variableKey("", name);
  }

  /** The node of this task at which an event is shown: that of a subtask's inside at the subtask. */
  shownAt(path: string): string {
    let at = path;
    while (!this.byPath.has(at) && at.includes("/") && at !== "/") at = at.slice(0, at.lastIndexOf("/"));
    return this.byPath.has(at) ? at : path;
  }

  descendants(path: string): readonly string[] {
    const found: string[] = [];
    const open = [...(this.byPath.get(path)?.children ?? [])];
    for (let next = open.pop(); next !== undefined; next = open.pop()) {
      found.push(next);
      open.push(...(this.byPath.get(next)?.children ?? []));
    }
    return found;
  }
}

/** The leaf that works; the last one that has begun, where several do. */
export function runningLeaf(index: TaskIndex, moment: Moment): string | null {
  let found: string | null = null;
  for (const [path, status] of moment.nodes) {
    if (status.phase === "running" && index.byPath.get(path)?.kind === "leaf") found = path;
  }
  return found;
}

export function variableKey(scope: string, name: string): string {
  return `${scope}:${name}`;
}

/** Take one event into a moment. Live view, replay and scrubbing all come through here. */
export function apply(moment: Moment, event: RunEvent, index: TaskIndex): void {
  moment.t = event.t;
  const { path } = event;
  const shown = index.shownAt(path);
  if (shown !== path && event.event !== "write") return applyInside(moment, event, shown);
  const before = moment.status(path);
  switch (event.event) {
    case "enter":
      // What the last activation of a container left behind says nothing about this one.
      for (const below of index.descendants(path)) moment.nodes.delete(below);
      moment.nodes.set(path, { phase: "running", since: event.t, activations: before.activations + 1 });
      break;
    case "exit":
      moment.nodes.set(path, {
        phase: index.phaseOf(path, event.outcome),
        since: event.t,
        activations: before.activations,
        outcome: event.outcome ?? undefined,
        code: event.code ?? undefined,
        message: text(event.data["message"]) || undefined,
      });
      break;
    case "interrupted":
      moment.nodes.set(path, { phase: "interrupted", since: event.t, activations: before.activations });
      break;
    case "message":
      moment.nodes.set(path, { ...before, message: text(event.data["text"]) || undefined });
      break;
    case "write":
      moment.variables.set(index.variable(path, text(event.data["variable"])), {
        type: text(event.data["type"]),
        preview: text(event.data["preview"]),
        writer: path,
        t: event.t,
        seq: event.seq,
      });
      break;
    case "state":
      moment.facts = { ...moment.facts, state: text(event.data["state"]) };
      break;
    case "error":
      if (before.phase === "running") moment.cut = new Map([...moment.cut, [path, before]]);
      moment.nodes.set(path, { ...before, phase: "error", since: event.t, message: text(event.data["message"]) });
      moment.facts = {
        ...moment.facts,
        error: {
          path,
          type: text(event.data["type"]),
          message: text(event.data["message"]),
          traceback: text(event.data["traceback"]),
        },
      };
      break;
    case "run_ended":
      for (const [open, status] of moment.nodes) {
        if (status.phase !== "running") continue;
        moment.cut = new Map([...moment.cut, [open, status]]);
        moment.nodes.set(open, { ...status, phase: "interrupted", since: event.t });
      }
      moment.facts = {
        ...moment.facts,
        state: "ended",
        status: text(event.data["status"]) || undefined,
        outcome: event.outcome ?? undefined,
      };
      break;
    case "run_resumed":
      for (const [open, status] of moment.cut) moment.nodes.set(open, status);
      moment.cut = new Map();
      moment.facts = { state: "running" };
      break;
  }
}

/** What happens inside a subtask, said at the subtask: which of its nodes does what. */
function applyInside(moment: Moment, event: RunEvent, shown: string): void {
  const before = moment.status(shown);
  const inner = event.path.slice(shown.length + 1);
  const label = [event.outcome, event.code].filter(Boolean).join(".");
  const said = text(event.data["message"]) || text(event.data["text"]);
  const words = { enter: "running", exit: label, interrupted: "interrupted", message: said, error: `${text(event.data["type"])}: ${said}` }[event.event];
  if (words === undefined) return;
  const message = `${inner}: ${event.event === "exit" && said ? `${words}, ${said}` : words}`;
  const failed = event.event === "error";
  moment.nodes.set(shown, { ...before, ...(failed ? { phase: "error" as const, since: event.t } : {}), message });
  if (failed) {
    const error = { path: event.path, type: text(event.data["type"]), message: said, traceback: text(event.data["traceback"]) };
    moment.facts = { ...moment.facts, error };
  }
}

function text(value: unknown): string {
  if (value === undefined || value === null) return "";
  return typeof value === "string" ? value : JSON.stringify(value);
}
