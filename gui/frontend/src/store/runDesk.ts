/** How runs are started from this page, and what all pages share: who holds control, where runs hold. */
import { create } from "zustand";

import { PAGE } from "../protocol/client";
import type { Breakpoint, SharedState, StartRun } from "../protocol/generated";

export type RunOptions = Pick<StartRun, "robot" | "target" | "seed" | "pace">;

export interface RunningStore {
  readonly options: RunOptions;
  /** Node -> script that is played in its place, of the next run. */
  readonly mocks: Readonly<Record<string, string>>;
  readonly desk: SharedState;
  setOptions(options: RunOptions): void;
  setMock(node: string, script: string): void;
  setDesk(desk: SharedState): void;
}

export const useRunning = create<RunningStore>()((set) => ({
  options: { robot: "sim", target: "bt", seed: 0, pace: 1 },
  mocks: {},
  desk: { holder: null, connections: 0, viewers: [], breakpoints: {} },
  setOptions: (options) => set({ options }),
  setMock: (node, script) =>
    set(({ mocks }) => {
      const { [node]: _, ...others } = mocks;
      return { mocks: script.trim() ? { ...others, [node]: script.trim() } : others };
    }),
  setDesk: (desk) => set({ desk }),
}));

/** Whether another page holds control. */
export function isHeldElsewhere(desk: SharedState): boolean {
  return desk.holder !== null && desk.holder !== PAGE;
}

/** Who holds control, in words. */
export function holderText(desk: SharedState): string {
  if (desk.holder === null) return "Nobody is in control";
  if (desk.holder === PAGE) return "You control";
  return `${desk.viewers.find((each) => each.page === desk.holder)?.name ?? "Another page"} controls`;
}

const NONE: readonly Breakpoint[] = [];

export function breakpointsOf(desk: SharedState, task: string): readonly Breakpoint[] {
  return desk.breakpoints[task] ?? NONE;
}
