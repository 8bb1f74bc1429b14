/** Words for people: statuses, times, events. Nothing is told by colour alone. */
import type { RunEvent, SessionView } from "../protocol/generated";
import type { NodeStatus, Phase, RunFacts } from "./status";

const PHASES: Record<Phase, string> = {
  idle: "not started",
  running: "running",
  success: "success",
  failure: "failure",
  ended: "ended",
  interrupted: "interrupted",
  error: "error",
};

/** Groups of the palette: what stands before the first `/` of a node's name, and what isn't a node. */
export const GROUPS: Record<string, string> = {
  containers: "Containers",
  flow: "Flow and values",
  arm: "Arm motions",
  hand: "Hand",
  grasp: "Grasps",
  pose: "Poses",
  scene: "Planning scene",
  sensor: "Sensors",
  perception: "Perception",
  component: "External components",
  messages: "Named messages",
  ros: "ROS topics, frames, parameters",
  btcpp: "BehaviorTree.CPP",
  nav2: "Nav2",
  smach: "SMACH",
  tasks: "Tasks of the project",
};

export function groupOf(id: string): string {
  return id.split("/")[0] ?? "";
}

/** `success`, `none (success)`, `failure.no_plan`, `running` ... */
export function statusText(status: NodeStatus): string {
  const { phase, outcome, code } = status;
  if (phase === "success" || phase === "failure" || phase === "ended") {
    const label = outcome ?? phase;
    const full = code ? `${label}.${code}` : label;
    return label === phase || phase === "ended" ? full : `${full} (${phase})`;
  }
  return PHASES[phase];
}

export function seconds(t: number): string {
  return `${t.toFixed(t < 10 ? 2 : 1)} s`;
}

/** The state of the run in the top bar. */
export function runText(session: SessionView | null): string {
  if (!session) return "no run";
  const { held } = session;
  if (session.state === "paused" && held) return `paused ${held.when} ${held.path}${held.why === "breakpoint" ? " (breakpoint)" : ""}`;
  if (session.state !== "ended") return session.state;
  const outcome = session.outcome ? `: ${session.outcome}` : "";
  return `${session.status ?? "ended"}${outcome}${session.contradiction ? ", contradicted" : ""}`;
}

export interface Notice {
  readonly text: string;
  readonly bad: boolean;
}

/** What a person must not miss of the process. Errors in nodes are told with their traceback, from the journal. */
export function processNotices(session: SessionView | null): Notice[] {
  if (!session) return [];
  const { state, status, message, contradiction, rest, unconfirmed, zombies } = session;
  const lost = state === "ended" && (status === "killed" || status === "died" || session.run === null);
  const found: Notice[] = [];
  if (message && (lost || state !== "ended")) found.push({ text: message, bad: lost });
  if (contradiction) found.push({ text: `the simulator's referee disagrees: ${contradiction}`, bad: true });
  if (rest) found.push({ text: `${status}; ${rest}`, bad: unconfirmed.length > 0 });
  if (zombies.length > 0) found.push({ text: `Hung at the end and left running: ${zombies.join(", ")}`, bad: true });
  return found;
}

export function factsText(facts: RunFacts): string {
  if (facts.state !== "ended") return facts.state;
  return facts.outcome ? `${facts.status ?? "ended"}: ${facts.outcome}` : (facts.status ?? "ended");
}

const WENT_ON: Readonly<Record<string, string>> = {
  resume: "continues",
  restart: "is started again",
  result: "has ended as set by hand",
};

/** One line of the log. */
export function eventText(event: RunEvent): string {
  const data = event.data;
  switch (event.event) {
    case "enter":
      return "starts";
    case "exit": {
      const label = event.code ? `${event.outcome}.${event.code}` : `${event.outcome}`;
      return data["message"] ? `${label}: ${String(data["message"])}` : label;
    }
    case "write":
      return `${String(data["variable"])} = ${String(data["preview"])}`;
    case "message":
      return String(data["text"] ?? "");
    case "state":
      return `the run is ${String(data["state"])}`;
    case "error":
      return `${String(data["type"])}: ${String(data["message"])}`;
    case "run_ended":
      if (data["status"] === "lost") return "the run's process is gone";
      return `the run ended: ${[data["status"], event.outcome].filter(Boolean).map(String).join(", ")}${data["rest"] ? `; ${String(data["rest"])}` : ""}`;
    case "run_started":
      return "the run starts";
    case "run_resumed": {
      const back = Object.keys((data["restored"] as object | undefined) ?? {});
      return `the run resumes in another process${back.length ? `; as before: ${back.join(", ")}` : ""}`;
    }
    case "went_on":
      return WENT_ON[String(data["how"])] ?? `goes on: ${String(data["how"])}`;
    case "kept":
      return `its ${String(data["part"])} is saved for resuming`;
    case "preempt_requested":
      return "is asked to stop";
    case "interrupted":
      return "is halted";
    case "zombie":
      return `left behind: its code hangs in ${String(data["where"])}`;
    default:
      return event.event;
  }
}
