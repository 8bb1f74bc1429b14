/** The events of one run, and the moment after any of them: near a kept copy, then forward by the same reducer. */
import type { HistoryView, RunEvent, TaskView } from "../protocol/generated";
import { apply, Moment, type TaskIndex } from "./status";

const KEEP_EVERY = 256;

export class History {
  readonly events: RunEvent[] = [];
  private readonly kept: Moment[] = [new Moment()];
  private latest = new Moment();
  /** The run's clock at its first event [s]: a simulator's is older than the run. Times here count from it. */
  private origin: number | null = null;

  constructor(readonly index: TaskIndex) {}

  get length(): number {
    return this.events.length;
  }

  /** What the run's clock said when it began [s]; the times of its events count from there. */
  get start(): number {
    return this.origin ?? 0;
  }

  /** Number of the next event that is missing. */
  get nextSeq(): number {
    return (this.events.at(-1)?.seq ?? -1) + 1;
  }

  /** Add events that follow those that are there; what came twice is left out. */
  add(events: readonly RunEvent[]): void {
    for (const given of events) {
      if (given.seq < this.nextSeq) continue;
      this.origin ??= given.t;
      const event = { ...given, t: given.t - this.origin };
      this.events.push(event);
      apply(this.latest, event, this.index);
      if (this.events.length % KEEP_EVERY === 0) this.kept.push(this.latest.copy());
    }
  }

  /** Say that no more will come. A run whose process died has written no end, so one is put in its place. */
  close(): void {
    const last = this.events.at(-1);
    if (!last || last.event === "run_ended") return;
    const end = { seq: last.seq + 1, t: last.t + (this.origin ?? 0), path: "/", event: "run_ended", outcome: null, code: null };
    this.add([{ ...end, data: { status: "lost" } }]);
  }

  /** The moment after all events; it changes as events are added. */
  now(): Moment {
    return this.latest;
  }

  /** A copy of the moment after the first `count` events. */
  at(count: number): Moment {
    const wanted = Math.max(0, Math.min(count, this.events.length));
    const start = Math.floor(wanted / KEEP_EVERY);
    const moment = (this.kept[start] ?? new Moment()).copy();
    for (let i = start * KEEP_EVERY; i < wanted; i++) apply(moment, this.events[i] as RunEvent, this.index);
    return moment;
  }

  /** How many events had happened `t` [s] after the first. */
  countAt(t: number): number {
    let low = 0;
    let high = this.events.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if ((this.events[middle] as RunEvent).t <= t) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}

export interface MomentRow {
  readonly number: number;
  readonly title: string;
  readonly branch: number;
  /** Whether the branch begins here. */
  readonly starts: boolean;
  readonly current: boolean;
}

export function historyRows(history: HistoryView): MomentRow[] {
  const byNumber = new Map(history.moments.map((moment) => [moment.number, moment]));
  const line = new Set<number>();
  for (let at = byNumber.get(history.at); at; at = at.parent === null ? undefined : byNumber.get(at.parent)) line.add(at.number);
  // What follows the present moment, youngest first, is the way that a redo takes.
  for (let at: number | undefined = history.at; at !== undefined; ) {
    at = history.moments.filter((moment) => moment.parent === at).at(-1)?.number;
    if (at !== undefined) line.add(at);
  }
  const branches = new Map<number, number>();
  let count = 0;
  for (const moment of history.moments) {
    if (line.has(moment.number)) branches.set(moment.number, 0);
    else branches.set(moment.number, (moment.parent === null ? 0 : branches.get(moment.parent)) || ++count);
  }
  return [...history.moments].reverse().map((moment) => {
    const branch = branches.get(moment.number) ?? 0;
    const starts = moment.parent === null || branches.get(moment.parent) !== branch;
    return { number: moment.number, title: moment.title, branch, starts, current: moment.number === history.at };
  });
}

/** @param checked whether its problems are known; until they are, those of before are shown, of nodes that are still there. */
export function sharing(task: TaskView, before: TaskView, checked: boolean): TaskView {
  const known = new Map(before.nodes.map((node) => [node.path, node]));
  const nodes = task.nodes.map((node) => {
    const old = known.get(node.path);
    return old !== undefined && JSON.stringify(old) === JSON.stringify(node) ? old : node;
  });
  const there = new Set(task.nodes.map((node) => node.path));
  const problems = checked ? task.problems : before.problems.filter(({ path }) => path === "" || there.has(path));
  const now = { ...task, nodes, problems };
  const rest = (view: TaskView): string => JSON.stringify({ ...view, nodes: [] });
  const same = nodes.length === before.nodes.length && nodes.every((node, i) => node === before.nodes[i]) && rest(now) === rest(before);
  return same ? before : now;
}

/** Where a node is after a change: what is below one that was moved has moved with it. */
export function whereNow(path: string, known: ReadonlyMap<string, unknown>, moved: Readonly<Record<string, string>>): string {
  if (known.has(path)) return path;
  for (let above: string | null = path, below = ""; above !== null; below = path.slice((above ?? "").length)) {
    const to = moved[above];
    const now = to === undefined ? undefined : to === "/" && below !== "" ? below.slice(1) : to + below;
    if (now !== undefined && known.has(now)) return now;
    above = above.includes("/") ? above.slice(0, above.lastIndexOf("/")) : null;
  }
  return path;
}
