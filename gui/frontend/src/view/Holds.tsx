/** Where runs of the task hold, and what is played in place of nodes. */
import { type JSX, useState } from "react";

import type { Breakpoint } from "../protocol/generated";
import { actionTitle } from "../store/actions";
import { usePage } from "../store/page";
import { useRun } from "../store/run";
import { breakpointsOf, useRunning } from "../store/runDesk";
import { runFromHere, runToHere, setBreakpoints, toggleBreakpoint } from "../store/running";

export function Holds(): JSX.Element {
  const task = useRun((s) => s.task.path);
  const points = useRunning((s) => breakpointsOf(s.desk, task));
  const selected = usePage((s) => s.selected);
  return (
    <div className="holds">
      <section className="panel" aria-labelledby="holds-title">
        <div className="holds-head">
          <h2 id="holds-title">Breakpoints</h2>
          <button disabled={selected === null} title={actionTitle("breakpoint")} onClick={() => void toggleBreakpoint()}>
            At the selected node
          </button>
          <button disabled={selected === null} title={actionTitle("to-here")} onClick={runToHere}>
            Run to here
          </button>
          <button disabled={selected === null} title={actionTitle("from-here")} onClick={() => void runFromHere()}>
            Run from here
          </button>
          {points.length > 0 && <button onClick={() => void setBreakpoints([])}>Clear all</button>}
        </div>
        <div className="scroll padded" tabIndex={0} role="group" aria-labelledby="holds-title">
          {points.length === 0 && <p className="hint">No breakpoints. Select a node and press F9.</p>}
          <ul className="plain">
            {points.map((point, at) => (
              <PointRow key={`${point.node} ${point.when} ${point.outcome}`} point={point} change={(next) => void setBreakpoints(points.flatMap((each, i) => (i === at ? (next ? [next] : []) : [each])))} />
            ))}
          </ul>
        </div>
      </section>
      <Mocks selected={selected} />
    </div>
  );
}

function PointRow({ point, change }: { point: Breakpoint; change: (next: Breakpoint | null) => void }): JSX.Element {
  const node = useRun((s) => s.index.byPath.get(point.node));
  const [condition, setCondition] = useState(point.condition);
  const where = `${point.when}${point.outcome ? `:${point.outcome}` : ""}`;
  function move(value: string): void {
    const [when, outcome] = value.split(":");
    change({ ...point, when: when as Breakpoint["when"], outcome: outcome ?? null });
  }
  return (
    <li className="hold-row">
      <button className="link" onClick={() => usePage.getState().select(point.node)}>
        {point.node}
      </button>
      {!node && <span className="hint">isn't in the task</span>}
      <select aria-label={`When ${point.node} holds`} value={where} onChange={(event) => move(event.target.value)}>
        <option value="before">before it begins</option>
        <option value="after">after it has ended</option>
        {[...new Set([...Object.keys(node?.outcomes ?? {}), ...(point.outcome ? [point.outcome] : [])])].map((outcome) => (
          <option key={outcome} value={`after:${outcome}`}>
            after {outcome}
          </option>
        ))}
      </select>
      <input
        aria-label={`Condition at ${point.node}`}
        placeholder="always; or such as count > 2"
        value={condition}
        onChange={(event) => setCondition(event.target.value)}
        onBlur={() => condition !== point.condition && change({ ...point, condition })}
        onKeyDown={(event) => event.key === "Enter" && change({ ...point, condition })}
      />
      <button aria-label={`Clear the breakpoint at ${point.node}`} onClick={() => change(null)}>
        Clear
      </button>
    </li>
  );
}

function Mocks({ selected }: { selected: string | null }): JSX.Element {
  const mocks = useRunning((s) => s.mocks);
  const { setMock } = useRunning.getState();
  const paths = [...new Set([...Object.keys(mocks), ...(selected === null ? [] : [selected])])];
  return (
    <section className="panel" aria-labelledby="mocks-title">
      <h2 id="mocks-title">Mocks</h2>
      <div className="scroll padded" tabIndex={0} role="group" aria-labelledby="mocks-title">
        <p className="hint">
          A script plays the node's part in the next runs from this page: <code>failure.no_ik,success</code> fails once, then succeeds.
        </p>
        {paths.map((path) => (
          <label key={path} className="mock-row">
            <code>{path}</code>
            <input value={mocks[path] ?? ""} placeholder="itself" onChange={(event) => setMock(path, event.target.value)} />
          </label>
        ))}
      </div>
    </section>
  );
}
