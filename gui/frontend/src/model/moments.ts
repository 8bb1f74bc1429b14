/** The history as a list: the newest first, branches that were left indented. */
import type { HistoryView } from "../protocol/generated";

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
