/** What the validation says about the task; errors keep it from running, never from being drawn. */
import { type JSX, useState } from "react";

import type { Command } from "../model/commands";
import type { Problem } from "../protocol/generated";
import { added } from "../store/begin";
import { edit, editable } from "../store/editing";
import { usePage } from "../store/page";
import { useRun } from "../store/run";

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
      {!locked && MADE.test(`${problem.code} ${problem.message}`) && (
        <span className="fixes">
          <button onClick={() => void added()}>Add what the robot has</button>
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
