/** What this page tells the others of itself: the name that its person chose, and what it shows. */
import { usePage } from "./page";
import { useRun } from "./run";

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
