/** The selections of other pages, and what this one tells them: its name, what it shows, what is selected. */
import { create } from "zustand";

import { pagesAt, type Selections, taken, toTell } from "../model/others";
import type { Viewer, Selected, Selection } from "../protocol/generated";
import { usePage } from "./page";
import { useRun } from "./run";
import { useRunning } from "./runDesk";

const KEY = "grip-name";
export const LONGEST_NAME = 40;

/** The name that the person chose, for all tabs of this browser; empty for the one that the server gives. */
export function givenName(): string {
  return (localStorage.getItem(KEY) ?? "").slice(0, LONGEST_NAME);
}

export function keepName(name: string): void {
  localStorage.setItem(KEY, name.trim().slice(0, LONGEST_NAME));
}

/** The task file that this page shows; empty while it shows the project's files. */
export function lookedAt(): string {
  return usePage.getState().room === "task" ? useRun.getState().task.path : "";
}

interface OthersStore {
  readonly selections: Selections;
  hear(news: Readonly<Record<string, Selected | null>>): void;
  forget(): void;
}

export const useOthers = create<OthersStore>()((set) => ({
  selections: {},
  hear: (news) => set(({ selections }) => ({ selections: taken(selections, news) })),
  forget: () => set({ selections: {} }),
}));

const NOBODY: readonly Viewer[] = [];

/** Who else has this node selected, or, where it is `folded`, something inside it. */
export function useOthersAt(path: string, folded: boolean): readonly Viewer[] {
  const task = useRun((s) => s.task.path);
  // As text, which is the same as long as the same pages are meant.
  const pages = useOthers((s) => pagesAt(s.selections, task, path, folded).join(" "));
  const viewers = useRunning((s) => s.desk.viewers);
  return pages === "" ? NOBODY : viewers.filter((each) => pages.split(" ").includes(each.page));
}

/** What this page tells the others. */
export function ownSelection(): Selection {
  const { selected, marked } = usePage.getState();
  const task = lookedAt();
  return { type: "selection", task, nodes: task === "" ? [] : toTell(selected, marked) };
}

/** Shortest time between two messages [ms]: a person sees no difference, and a drag over many nodes sends few. */
const PAUSE = 150;

/** Call `send` with what is selected whenever that has changed, at most once in `PAUSE`; returns how to end it. */
export function tellSelection(send: (selection: Selection) => void): () => void {
  let told = "";
  let timer: ReturnType<typeof setTimeout> | undefined;
  const tell = (): void => {
    if (timer !== undefined) return;
    const selection = ownSelection();
    const text = JSON.stringify(selection);
    if (text === told) return;
    told = text;
    send(selection);
    timer = setTimeout(() => {
      timer = undefined;
      tell();
    }, PAUSE);
  };
  const ends = [usePage.subscribe(tell), useRun.subscribe(tell)];
  tell();
  return () => {
    clearTimeout(timer);
    for (const end of ends) end();
  };
}
