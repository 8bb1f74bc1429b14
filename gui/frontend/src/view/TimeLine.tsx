/** The run over time: a bar per activation of a leaf, and a slider that shows any moment again, during and after the run. */
import { type JSX, type KeyboardEvent, type PointerEvent, useEffect, useMemo, useState } from "react";

import { eventText, factsText, seconds } from "../model/words";
import { spansOf } from "../model/timeline";
import type { RunRecord } from "../protocol/generated";
import { chooseRun, listRuns } from "../store/desk";
import { usePage } from "../store/page";
import { hold, play, useReplay, useRun } from "../store/run";

/** So that a single bar doesn't fill the whole height. */
const LEAST_LANES = 2;

/** Why there are no events. */
const NOTHING = {
  begun: "The run has told nothing yet.",
  edited: "Edited: choose a run to see it.",
  never: "Nothing has run yet.",
};

export function TimeLine(): JSX.Element {
  const record = useRun((s) => s.record);
  const ran = useRun((s) => s.session?.run != null);
  const version = useRun((s) => s.version);
  const { history, cursor, moment, scrub, index } = useRun.getState();
  const follow = usePage((s) => s.follow);
  const playing = useReplay((s) => s.playing);
  const live = useRun((s) => s.cursor === null && !s.complete);
  const spans = useMemo(() => spansOf(history.events, index), [history, index, version]);
  const end = Math.max(history.events.at(-1)?.t ?? 0, 1e-6);
  const shown = cursor ?? history.length;
  const event = history.events[shown - 1];
  const percent = (t: number): string => `${(t / end) * 100}%`;
  const lanes = spans.reduce((most, span) => Math.max(most, span.lane + 1), LEAST_LANES);

  function go(count: number): void {
    scrub(count >= history.length ? null : Math.max(0, count));
  }
  function onKeyDown(key: KeyboardEvent): void {
    const steps: Record<string, number> = {
      ArrowLeft: shown - 1,
      ArrowDown: shown - 1,
      ArrowRight: shown + 1,
      ArrowUp: shown + 1,
      PageDown: shown - 10,
      PageUp: shown + 10,
      Home: 0,
      End: history.length,
    };
    const to = steps[key.key];
    if (to === undefined) return;
    key.preventDefault();
    go(to);
  }
  function onPointer(pointer: PointerEvent<HTMLElement>): void {
    if (pointer.buttons !== 1 || history.length === 0) return;
    pointer.currentTarget.setPointerCapture(pointer.pointerId);
    const box = pointer.currentTarget.getBoundingClientRect();
    const part = Math.max(0, Math.min(1, (pointer.clientX - box.left) / box.width));
    go(part >= 1 ? history.length : history.countAt(part * end));
  }

  return (
    <section className="panel time-line" aria-labelledby="time-title">
      <div className="time-head">
        <h2 id="time-title">Time line</h2>
        <RunPicker />
        <span className="time-words" title={factsText(moment.facts)}>
          {history.length === 0
            ? NOTHING[record ? "begun" : ran ? "edited" : "never"]
            : `${seconds(event?.t ?? 0)} of ${seconds(end)}, event ${shown} of ${history.length}, ${factsText(moment.facts)}`}
        </span>
        <label className="check">
          <input type="checkbox" checked={follow} onChange={(e) => usePage.getState().setFollow(e.target.checked)} />
          Follow
        </label>
        <button disabled={history.length === 0 || live} onClick={playing ? hold : play}>
          {playing ? "Hold" : "Play"}
        </button>
        <button disabled={shown === 0} aria-label="Previous event" onClick={() => go(shown - 1)}>
          ◂
        </button>
        <button disabled={shown >= history.length} aria-label="Next event" onClick={() => go(shown + 1)}>
          ▸
        </button>
        <button disabled={cursor === null} onClick={() => scrub(null)}>
          Latest
        </button>
      </div>
      <div
        className="time-track"
        role="slider"
        tabIndex={0}
        aria-label="Moment of the run"
        aria-valuemin={0}
        aria-valuemax={history.length}
        aria-valuenow={shown}
        aria-valuetext={event ? `${seconds(event.t)}, ${event.path} ${eventText(event)}` : "before the first event"}
        onKeyDown={onKeyDown}
        onPointerDown={onPointer}
        onPointerMove={onPointer}
      >
        {spans.map((span, i) => (
          <div
            key={i}
            className={`span phase-${span.phase}`}
            title={`${span.path}: ${span.phase}, ${seconds(span.from)} to ${seconds(span.to ?? end)}`}
            style={{
              left: `min(${percent(span.from)}, 100% - 2px)`,
              maxWidth: `max(2px, calc(100% - ${percent(span.from)}))`,
              width: percent((span.to ?? end) - span.from),
              top: `${(span.lane / lanes) * 100}%`,
              height: `${100 / lanes}%`,
            }}
          >
            {span.path.split("/").at(-1)}
          </div>
        ))}
        {history.length > 0 && <div className="cursor" style={{ left: percent(event?.t ?? 0) }} />}
      </div>
    </section>
  );
}

/** Short: the field that shows it is. */
const WHEN = new Intl.DateTimeFormat(undefined, { day: "numeric", month: "short", hour: "2-digit", minute: "2-digit", second: "2-digit", hourCycle: "h23" });

function RunPicker(): JSX.Element {
  const record = useRun((s) => s.record);
  const ended = useRun((s) => s.session?.state === "ended");
  const run = useRun((s) => s.session?.run);
  const [runs, setRuns] = useState<RunRecord[]>([]);
  useEffect(() => {
    void listRuns().then(setRuns);
  }, [run, ended]);
  return (
      <select
        aria-label="Run to look at"
        value={record?.id ?? ""} onChange={(event) => event.target.value !== "" && void chooseRun(event.target.value)}
      >
        {!record && <option value="">choose a run</option>}
        {runs.map((entry) => (
          <option key={entry.id} value={entry.id}>
            {`${WHEN.format(entry.started * 1000)} · ${entry.task_name} · ${entry.outcome ?? entry.status}`}
          </option>
        ))}
      </select>
  );
}
