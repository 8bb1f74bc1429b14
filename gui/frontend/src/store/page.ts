/** What this page shows of the task: selection, open containers, which view, whether the canvas follows the run. */
import { create } from "zustand";

import { opened } from "../model/visibility";

export type ViewName = "tree" | "flow" | "split" | "text" | "robot";
export type FootTab = "problems" | "run" | "holds" | "history";

/** A task, or the files that put the project together. */
export type Room = "task" | "project";

/** A task that was left by going into one of its subtasks. */
export interface Above {
  readonly task: string;
  readonly name: string;
  /** The subtask. */
  readonly node: string;
}

export interface PageStore {
  readonly room: Room;
  /** The node that has the focus; forms are about it. */
  readonly selected: string | null;
  /** All nodes that are selected, the one with the focus among them. */
  readonly marked: ReadonlySet<string>;
  /** How often the person has selected something; what comes of an edit isn't counted. */
  readonly picks: number;
  readonly closed: ReadonlySet<string>;
  readonly follow: boolean;
  readonly view: ViewName;
  /** What stands beside the tree in the split view. */
  readonly beside: "flow" | "text";
  /** The container whose inside the flow chart shows. */
  readonly container: string;
  /** The tasks through whose subtasks this one was come to, the outermost first. */
  readonly trail: readonly Above[];
  /** Containers whose inside the flow chart shows in place. */
  readonly opened: ReadonlySet<string>;
  readonly foot: FootTab;
  /** Variable whose writers and readers are lit: its key. */
  readonly lens: string | null;
  select(path: string | null): void;
  /** Add a node to the selection, or take it out. */
  mark(path: string): void;
  markAll(paths: Iterable<string>): void;
  /** Select what an edit has made. */
  settle(paths: Iterable<string>): void;
  setClosed(path: string, closed: boolean): void;
  setFollow(follow: boolean): void;
  setView(view: ViewName): void;
  setBeside(beside: "flow" | "text"): void;
  enter(container: string): void;
  openInPlace(path: string, open: boolean): void;
  setFoot(foot: FootTab): void;
  setLens(lens: string | null): void;
  setRoom(room: Room): void;
}

export const usePage = create<PageStore>()((set) => ({
  selected: null,
  marked: new Set(),
  picks: 0,
  closed: new Set(),
  follow: true,
  view: "tree",
  beside: "flow",
  container: "/",
  trail: [],
  opened: new Set(),
  foot: "problems",
  lens: null,
  room: "task",
  select: (selected) => set(({ closed, picks }) => ({ picks: picks + 1, selected, marked: new Set(selected === null ? [] : [selected]), closed: opened(closed, selected === null ? [] : [selected]) })),
  mark: (path) =>
    set(({ marked, selected, picks }) => {
      const next = new Set(marked);
      if (next.has(path) && next.size > 1) next.delete(path);
      else next.add(path);
      const focus = next.has(path) ? path : selected !== null && next.has(selected) ? selected : [...next][0];
      return { picks: picks + 1, marked: next, selected: focus ?? null };
    }),
  markAll: (paths) => set((state) => ({ picks: state.picks + 1, ...all(state.closed, paths) })),
  settle: (paths) => set((state) => all(state.closed, paths)),
  setClosed: (path, closed) =>
    set((state) => {
      const next = new Set(state.closed);
      if (closed) next.add(path);
      else next.delete(path);
      // What is selected stays in sight: a node that is folded away gives way to its container.
      const inside = closed && state.selected !== null && state.selected !== path && (path === "/" || state.selected.startsWith(`${path}/`));
      return inside ? { closed: next, selected: path, marked: new Set([path]) } : { closed: next };
    }),
  setFollow: (follow) => set({ follow }),
  setView: (view) => set({ view }),
  setBeside: (beside) => set({ beside }),
  enter: (container) => set({ container }),
  openInPlace: (path, open) =>
    set(({ opened }) => {
      const next = new Set(opened);
      if (open) next.add(path);
      else next.delete(path);
      return { opened: next };
    }),
  setFoot: (foot) => set({ foot }),
  setLens: (lens) => set({ lens }),
  setRoom: (room) => set({ room }),
}));

/** Several nodes as the selection, the last with the focus. */
function all(closed: ReadonlySet<string>, paths: Iterable<string>): Pick<PageStore, "marked" | "selected" | "closed"> {
  const marked = new Set(paths);
  return { marked, selected: [...marked].at(-1) ?? null, closed: opened(closed, marked) };
}

/** What takes the focus in a panel first: what is chosen in a tree, then a field, then anything. */
const STARTS = ['[role="treeitem"][tabindex="0"]', '[aria-current="page"]', "input, select, textarea", "button, a[href], [tabindex='0']"];

function startOf(panel: Element): HTMLElement | undefined {
  for (const selector of STARTS) {
    const found = [...panel.querySelectorAll<HTMLElement>(selector)].find((each) => !each.matches(":disabled") && each.offsetParent !== null);
    if (found !== undefined) return found;
  }
  return undefined;
}

/** Panels in the order of the page, and those that can take the focus alone. */
function panels(): [Element, HTMLElement][] {
  return [...document.querySelectorAll(".bar, .panel, main, [role=tablist]")]
    .filter((each) => each.parentElement?.closest(".panel, main") === null)
    .flatMap((panel) => {
      const start = startOf(panel);
      return start === undefined ? [] : [[panel, start] as [Element, HTMLElement]];
    });
}

/** Go to the next panel, or with -1 to the one before; behind the last is the first. */
export function goToPanel(by: 1 | -1): void {
  const all = panels();
  const at = all.findIndex(([panel]) => panel.contains(document.activeElement));
  const next = at < 0 ? 0 : (at + by + all.length) % all.length;
  all[next]?.[1].focus();
}

/** After something was made from the bar above, or from nowhere: the keys that follow are about what was made. */
export function goToTree(): void {
  // The dialog that asked gives the focus back first.
  setTimeout(() => {
    const { activeElement } = document;
    if (activeElement !== document.body && activeElement?.closest(".bar") == null) return;
    document.querySelector<HTMLElement>('[role="tree"] [role="treeitem"][tabindex="0"]')?.focus({ preventScroll: true });
  });
}
