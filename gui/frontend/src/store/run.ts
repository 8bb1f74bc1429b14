/** The run that is looked at: its events, the moment that is shown, and the process behind it. */
import { create } from "zustand";

import { History } from "../model/history";
import { Moment, TaskIndex } from "../model/status";
import type { RunEvent, RunRecord, SessionView, TaskView } from "../protocol/generated";

const NO_TASK: TaskView = { path: "", name: "", doc: "", outcomes: {}, nodes: [], variables: [], problems: [] };

export interface RunStore {
  readonly task: TaskView;
  readonly index: TaskIndex;
  readonly record: RunRecord | null;
  readonly history: History;
  /** What is shown: the latest moment when live, else a copy of an earlier one. */
  readonly moment: Moment;
  /** How many events are taken into `moment` while scrubbing; null while it follows the run. */
  readonly cursor: number | null;
  readonly complete: boolean;
  /** Grows with every change, since `history` and the live moment change in place. */
  readonly version: number;
  readonly session: SessionView | null;
  /** Null before the first connection. */
  readonly connected: boolean | null;
  /** Whether a server answers that another page belongs to: it was started anew, with another token. */
  readonly stranger: boolean;
  readonly error: string;

  showTask(task: TaskView, record?: RunRecord | null): void;
  /** The same task, with what is wrong with it. */
  setProblems(task: TaskView): void;
  addEvents(run: string, events: readonly RunEvent[], complete: boolean): void;
  scrub(cursor: number | null): void;
  setSession(session: SessionView | null): void;
  setConnected(connected: boolean, stranger?: boolean): void;
  setError(error: string): void;
}

export const useRun = create<RunStore>()((set, get) => ({
  ...fresh(NO_TASK),
  record: null,
  version: 0,
  session: null,
  connected: null,
  stranger: false,
  error: "",

  showTask: (task, record = null) => set((s) => ({ ...fresh(task), record, version: s.version + 1 })),

  setProblems: (task) => set({ task, index: new TaskIndex(task) }),

  addEvents: (run, events, complete) => {
    const { record, history, cursor, version } = get();
    if (record?.id !== run) return;
    history.add(events);
    if (complete) history.close();
    set({ complete, version: version + 1, ...(cursor === null ? { moment: history.now() } : {}) });
  },

  scrub: (cursor) => {
    const { history, version } = get();
    const moment = cursor === null ? history.now() : history.at(cursor);
    set({ cursor, moment, version: version + 1 });
  },

  setSession: (session) => set({ session }),
  setConnected: (connected, stranger = false) => set({ connected, stranger }),
  setError: (error) => set({ error }),
}));

function fresh(task: TaskView): Pick<RunStore, "task" | "index" | "history" | "moment" | "cursor" | "complete"> {
  const index = new TaskIndex(task);
  const history = new History(index);
  return { task, index, history, moment: history.now(), cursor: null, complete: false };
}

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
