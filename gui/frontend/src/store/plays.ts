/** Where two forms of a task differ, played on the page: each form's run is shown like one of the journal. */
import { create } from "zustand";

import type { ConversionView, PlayView, RunRecord } from "../protocol/generated";
import { usePage } from "./page";
import { play } from "./replay";
import { useRun } from "./run";

export type Side = "now" | "then";

interface PlaysStore {
  /** What is played: the form as it is, and the other one. */
  readonly plays: readonly PlayView[];
  readonly script: readonly string[];
  /** Asks again what to do with the conversion. */
  readonly decide: () => void;
}

export const usePlays = create<PlaysStore>()(() => ({ plays: [], script: [], decide: () => {} }));

/** Ids of runs that no journal holds begin with this. */
const MARK = "#played-";
export const SIDES: readonly (readonly [Side, string])[] = [
  ["now", "As it is"],
  ["then", "As it would be"],
];

/** Which form's run is shown; null where it is another run, or none. */
export function sideOf(record: RunRecord | null): Side | null {
  return record?.id.startsWith(MARK) ? (record.id.slice(MARK.length) as Side) : null;
}

export function isKept(run: string | undefined): run is string {
  return run !== undefined && !run.startsWith(MARK);
}

/** Keep what came of comparing two forms, to play it. */
export function keepPlays(found: ConversionView, decide: () => void): void {
  usePlays.setState({ plays: found.plays, script: found.script, decide });
}

export function showPlay(side: Side): void {
  const view = usePlays.getState().plays[side === "now" ? 0 : 1];
  if (view === undefined) return;
  const { task, status, outcome, events } = view;
  const id = MARK + side;
  const run = useRun.getState();
  run.showTask(task, { id, task_name: task.name, task_path: task.path, target: "bt", seed: null, started: 0, ended: 0, status, outcome, damage: "" });
  run.addEvents(id, events, true);
  run.scrub(0);
  const known = useRun.getState().index.byPath;
  const { selected, container } = usePage.getState();
  usePage.setState({ foot: "run", follow: true, ...(known.has(container) ? {} : { container: "/" }), ...(selected !== null && !known.has(selected) ? { selected: "/", marked: new Set(["/"]) } : {}) });
  play();
}
