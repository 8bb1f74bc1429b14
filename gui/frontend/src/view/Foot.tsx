/** Below the views: problems, the run, the history of edits; one at a time. */
import type { JSX, KeyboardEvent } from "react";

import { type FootTab, usePage } from "../store/page";
import { setRobotOpen, useRobot } from "../store/robot";
import { useRun } from "../store/run";
import { HistoryPanel } from "./edit/HistoryPanel";
import { EventLog } from "./EventLog";
import { Holds } from "./Holds";
import { Problems } from "./Problems";
import { TimeLine } from "./TimeLine";

const TABS: readonly [FootTab, string][] = [
  ["problems", "Problems"],
  ["run", "Run"],
  ["holds", "Breakpoints"],
  ["history", "History"],
];

export function Foot(): JSX.Element {
  const foot = usePage((s) => s.foot);
  const problems = useRun((s) => s.task.problems.length);
  const robot = useRobot((s) => s.open);
  const { setFoot } = usePage.getState();
  function onKeyDown(event: KeyboardEvent): void {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (by === undefined) return;
    const next = TABS[(TABS.findIndex(([name]) => name === foot) + by + TABS.length) % TABS.length] as readonly [FootTab, string];
    setFoot(next[0]);
    document.getElementById(`tab-${next[0]}`)?.focus();
  }
  return (
    <footer>
      <div className="foot-bar">
        <div className="tabs" role="tablist" aria-label="Below the views" aria-orientation="horizontal" onKeyDown={onKeyDown}>
          {TABS.map(([name, label]) => (
            <button key={name} id={`tab-${name}`} role="tab" aria-selected={foot === name} aria-controls="foot-panel" tabIndex={foot === name ? 0 : -1} onClick={() => setFoot(name)}>
              {label}
              {name === "problems" && problems > 0 && ` (${problems})`}
            </button>
          ))}
        </div>
        <button aria-pressed={robot} title="The robot at the shown moment" onClick={() => setRobotOpen(!robot)}>
          Robot in 3D
        </button>
      </div>
      <div id="foot-panel" role="tabpanel" aria-labelledby={`tab-${foot}`} className={`foot-panel foot-${foot}`}>
        {foot === "problems" && <Problems />}
        {foot === "run" && (
          <>
            <TimeLine />
            <EventLog />
          </>
        )}
        {foot === "holds" && <Holds />}
        {foot === "history" && <HistoryPanel />}
      </div>
    </footer>
  );
}
