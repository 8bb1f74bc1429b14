/** The buttons of the run, who looks on, and how it goes. STOP is always there, in one place, and always answers. */
import { type JSX, useEffect } from "react";

import { runText } from "../model/words";
import type { Control } from "../protocol/generated";
import { actionTitle } from "../store/actions";
import { useRun } from "../store/run";
import { control, start, step, stop } from "../store/running";
import { Presence } from "./Presence";

export function RunBar(): JSX.Element {
  const state = useRun((s) => s.session?.state ?? "ended");
  const empty = useRun((s) => s.task.nodes.length === 0);
  const broken = useRun((s) => s.task.problems.some((problem) => problem.severity === "error"));
  const paused = state === "paused";
  return (
    <div className="bar-part run-part">
      <div className="buttons">
        <button className="run" disabled={state !== "ended" || broken || empty} title={broken ? "The task has errors; see Problems" : actionTitle("run")} onClick={() => void start()}>
          Run
        </button>
        <button className="pause" disabled={!paused && state !== "running"} title={actionTitle("pause")} onClick={() => void control(paused ? "resume" : "pause")}>
          {paused ? "Resume" : "Pause"}
        </button>
        <button className="stop" aria-keyshortcuts="F8" title="Stop the run at once (F8)" onClick={stop}>
          STOP
        </button>
      </div>
      <Steps disabled={!paused} />
      <Presence />
      <RunState />
    </div>
  );
}

const STEPS: readonly [Control["how"], string, string][] = [
  ["over", "Step over", "over"],
  ["in", "Step in", "into"],
  ["out", "Step out", "step-out"],
  ["tick", "Step", "tick"],
];

function Steps({ disabled }: { disabled: boolean }): JSX.Element {
  return (
    <span className="buttons" role="group" aria-label="Steps of a paused run">
      {STEPS.map(([how, label, action]) => (
        <button key={how} disabled={disabled} title={actionTitle(action)} onClick={() => step(how)}>
          {label}
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
    const onKey = (event: KeyboardEvent): void => {
      if (event.key === "F8") {
        event.preventDefault();
        stop();
      }
    };
    window.addEventListener("keydown", onKey, { capture: true });
    return () => window.removeEventListener("keydown", onKey, { capture: true });
  }, []);
  const words = connected ? runText(session) : connected === null ? "connecting ..." : "no connection to the server";
  const status = session?.contradiction ? "failure" : session?.status;
  const kind = connected === false ? "lost" : session?.state === "ended" ? `ended-${status}` : (session?.state ?? "none");
  return (
    <output className={`run-state state-${kind}`} aria-live="polite" aria-label="State of the run" title={words}>
      {words}
    </output>
  );
}
