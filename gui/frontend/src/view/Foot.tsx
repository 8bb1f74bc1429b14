/** Below the views: problems (errors keep a task from running, never from being drawn), the run, the history of edits; one at a time. */
import { type JSX, type KeyboardEvent, useEffect, useRef, useState } from "react";

import { type Command, nameOf } from "../model/commands";
import { historyRows } from "../model/history";
import { runningLeaf } from "../model/status";
import { eventText, processNotices, seconds } from "../model/words";
import type { Problem } from "../protocol/generated";
import { added } from "../store/begin";
import { useDocument } from "../store/document";
import { edit, editable, goTo } from "../store/editing";
import { setRobotOpen, useRobot } from "../store/live";
import { type FootTab, usePage } from "../store/page";
import { usePanes } from "../store/panes";
import { useRun } from "../store/run";
import { Holds } from "./Holds";
import { Divider } from "./marks";
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
  const hidden = usePanes((s) => s.hidden.has("foot"));
  const said = useDocument((s) => s.said);
  const session = useRun((s) => s.session);
  const told = processNotices(session).flatMap(({ text, bad }) => (bad ? [] : [text])).join("; ");
  const { setFoot } = usePage.getState();
  function choose(tab: FootTab): void {
    usePanes.getState().toggle("foot", false);
    setFoot(tab);
  }
  function onKeyDown(event: KeyboardEvent): void {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (by === undefined) return;
    const next = TABS[(TABS.findIndex(([name]) => name === foot) + by + TABS.length) % TABS.length] as readonly [FootTab, string];
    choose(next[0]);
    document.getElementById(`tab-${next[0]}`)?.focus();
  }
  // Where nothing is wrong there is nothing to read.
  const closed = hidden || (foot === "problems" && problems === 0);
  return (
    <footer className={closed ? "closed" : ""}>
      {!closed && <Divider pane="foot" across="y" grows={-1} />}
      <div className="foot-bar">
        <div className="tabs" role="tablist" aria-label="Below the views" aria-orientation="horizontal" onKeyDown={onKeyDown}>
          {TABS.map(([name, label]) => (
            <button key={name} id={`tab-${name}`} role="tab" aria-selected={foot === name} aria-controls="foot-panel" tabIndex={foot === name ? 0 : -1} onClick={() => choose(name)}>
              {label}
              {name === "problems" && (problems > 0 ? ` (${problems})` : <span className="phase-success"> ✓</span>)}
            </button>
          ))}
        </div>
        <output className={foot === "problems" && problems === 0 ? "hint none" : "hidden"} aria-label="Problems">
          {problems === 0 ? "No problems." : `${problems} ${problems === 1 ? "problem" : "problems"}`}
        </output>
        {told && (
          <p className="told" role="status" title={told}>
            {told}
          </p>
        )}
        <WorksNow />
        <output className="said" aria-live="polite" aria-label="What was done" title={said}>
          {said}
        </output>
        <button aria-pressed={robot} title="The robot at the shown moment" onClick={() => setRobotOpen(!robot)}>
          Robot in 3D
        </button>
      </div>
      <div id="foot-panel" role="tabpanel" aria-labelledby={`tab-${foot}`} className={`foot-panel foot-${foot}`}>
        {foot === "problems" && problems > 0 && !hidden && <Problems />}
        {foot === "run" && !hidden && (
          <>
            <TimeLine />
            <EventLog />
          </>
        )}
        {foot === "holds" && !hidden && <Holds />}
        {foot === "history" && !hidden && <HistoryPanel />}
      </div>
    </footer>
  );
}

/** A leaf that works for less time than this isn't told of [ms]: words would come faster than they can be heard. */
const HEARD = 700;

/** For those who don't see the drawing: which leaf works. */
function WorksNow(): JSX.Element {
  const leaf = useRun((s) => (s.record === null || s.complete || s.cursor !== null ? null : runningLeaf(s.index, s.moment)));
  const [told, setTold] = useState<string | null>(null);
  useEffect(() => {
    const timer = setTimeout(() => setTold(leaf), HEARD);
    return () => clearTimeout(timer);
  }, [leaf]);
  return (
    <output className="hidden" aria-label="What works now">
      {told !== null && `${nameOf(told)} works`}
    </output>
  );
}

/** Most lines that are shown; the time line reaches the others. */
const SHOWN = 300;

export function EventLog(): JSX.Element {
  useRun((s) => s.version);
  const { history, cursor } = useRun.getState();
  const { select } = usePage.getState();
  const count = cursor ?? history.length;
  const first = Math.max(0, count - SHOWN);
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (box.current) box.current.scrollTop = box.current.scrollHeight;
  }, [count]);
  return (
    <section className="panel log" aria-labelledby="log-title">
      <h2 id="log-title">Events</h2>
      <div className="scroll" ref={box} tabIndex={0} role="group" aria-labelledby="log-title">
        {first > 0 && <p className="hint padded">{first} earlier events are on the time line.</p>}
        <ol>
          {history.events.slice(first, count).map((event) => (
            <li key={event.seq} className={`event-${event.event}`} onClick={() => select(event.path)}>
              <span className="event-time">{seconds(event.t)}</span>
              <span className="event-path">{event.path}</span>
              <span className="event-text">{eventText(event)}</span>
            </li>
          ))}
        </ol>
      </div>
    </section>
  );
}

export function HistoryPanel(): JSX.Element {
  const history = useDocument((s) => s.document?.history);
  const rows = history ? historyRows(history) : [];
  return (
    <section className="panel moments" aria-labelledby="moments-title">
      <h2 id="moments-title">History</h2>
      <ol className="scroll" tabIndex={0} aria-labelledby="moments-title">
        {rows.map((row) => (
          <li key={row.number} style={{ paddingInlineStart: `${8 + row.branch * 18}px` }}>
            <button className="link" {...(row.current ? { "aria-current": "step" as const } : {})} onClick={() => void goTo(row.number)}>
              {row.title}
            </button>
            {row.branch > 0 && row.starts && <span className="hint"> (branch)</span>}
            {row.current && <span className="hint"> (now)</span>}
          </li>
        ))}
      </ol>
    </section>
  );
}

/** So many problems are shown at first, and more by so many: a page of ten thousand would be slow at every edit. */
const AT_ONCE = 100;
/** What a project that has none of it can be given by its robot. */
const MADE = /^unknown-(arm|hand) the project has no |^unknown-node there is no node 'sensor\/overhead'/;

export function Problems(): JSX.Element {
  const problems = useRun((s) => s.task.problems);
  const errors = problems.filter((problem) => problem.severity === "error").length;
  return (
    <section className={`panel problems${errors ? " bad" : ""}`} aria-labelledby="problems-title">
      <h2 id="problems-title">
        Problems: {count(errors, "error")}, {count(problems.length - errors, "warning")}
      </h2>
      {problems.length > 0 ? <ProblemList problems={problems} label="Problems of the task" /> : <p className="hint padded">No problems.</p>}
    </section>
  );
}

/** Problems with what can be done about each; a short list leaves out where they are. */
export function ProblemList({ problems, label, short = false }: { problems: readonly Problem[]; label: string; short?: boolean }): JSX.Element {
  const [most, setMost] = useState(AT_ONCE);
  const left = problems.length - most;
  return (
    <ul className="problem-list scroll" tabIndex={0} aria-label={label}>
      {problems.slice(0, most).map((problem, i) => (
        <ProblemItem key={i} problem={problem} short={short} />
      ))}
      {left > 0 && (
        <li className="more">
          <button onClick={() => setMost(most + AT_ONCE)}>Show {Math.min(left, AT_ONCE)} more</button> <span className="hint">of {left} that aren't shown</span>
        </li>
      )}
    </ul>
  );
}

function ProblemItem({ problem, short }: { problem: Problem; short: boolean }): JSX.Element {
  const known = useRun((s) => s.index.byPath.has(problem.path));
  const locked = useRun((s) => s.record !== null);
  const { select } = usePage.getState();
  const lacks = MADE.exec(`${problem.code} ${problem.message}`);
  return (
    <li className={problem.severity}>
      <strong>{problem.severity}</strong>
      {!short && known && (
        <>
          {" "}
          <button className="link" onClick={() => select(problem.path)}>
            {problem.path}
          </button>
        </>
      )}
      {!short && problem.line !== null && <span className="hint"> line {problem.line}</span>} {problem.message}
      {problem.fix && problem.fixes.length === 0 && <em> Fix: {problem.fix}.</em>}
      {!locked && lacks && (
        <span className="fixes">
          <button onClick={() => void added(lacks[1] === "hand" ? "hands" : lacks[1] === "arm" ? "arms" : "robot")}>Add what the robot has</button>
        </span>
      )}
      {!locked && problem.fixes.length > 0 && (
        <span className="fixes">
          {problem.fixes.map((fix) => (
            <button key={fix.title} onClick={() => editable() && void edit(fix.command as Command)}>
              {fix.title}
            </button>
          ))}
        </span>
      )}
    </li>
  );
}

function count(n: number, what: string): string {
  return `${n === 0 ? "no" : n} ${what}${n === 1 ? "" : "s"}`;
}
