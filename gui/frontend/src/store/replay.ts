/** Playing what has been recorded: moment after moment, at the run's pace where that can be followed. */
import { create } from "zustand";

import { useRun } from "./run";

/** How long a moment is shown [s]: the run's own time between two events, within these. */
const LEAST = 0.12;
const MOST = 1;

export const useReplay = create<{ readonly playing: boolean }>()(() => ({ playing: false }));

let timer: ReturnType<typeof setTimeout> | undefined;

/** Play from the moment that is shown; from the beginning where that is the last one. */
export function play(): void {
  const { cursor, history, scrub } = useRun.getState();
  if (history.length === 0) return;
  if (cursor === null) scrub(0);
  useReplay.setState({ playing: true });
  next();
}

export function hold(): void {
  clearTimeout(timer);
  useReplay.setState({ playing: false });
}

function next(): void {
  clearTimeout(timer);
  const { cursor, history } = useRun.getState();
  if (cursor === null || cursor >= history.length) return hold();
  const [before, after] = [history.events[cursor - 1], history.events[cursor]];
  const pause = Math.min(MOST, Math.max(LEAST, (after?.t ?? 0) - (before?.t ?? 0)));
  timer = setTimeout(() => {
    const now = useRun.getState();
    // Who has moved to another moment meanwhile, or looks at something else, has stopped it.
    if (now.history !== history || now.cursor !== cursor) return hold();
    now.scrub(cursor + 1 >= history.length ? null : cursor + 1);
    next();
  }, pause * 1000);
}
