/** What this page shows of the task: selection, open containers, whether the canvas follows the run. */
import { create } from "zustand";

export interface PageStore {
  readonly selected: string | null;
  readonly closed: ReadonlySet<string>;
  readonly follow: boolean;
  select(path: string | null): void;
  setClosed(path: string, closed: boolean): void;
  setFollow(follow: boolean): void;
}

export const usePage = create<PageStore>()((set) => ({
  selected: null,
  closed: new Set(),
  follow: true,
  select: (selected) => set({ selected }),
  setClosed: (path, closed) =>
    set((state) => {
      const next = new Set(state.closed);
      if (closed) next.add(path);
      else next.delete(path);
      return { closed: next };
    }),
  setFollow: (follow) => set({ follow }),
}));
