/** How much room each pane of the page has, and which are put away; this browser remembers it. */
import { create } from "zustand";

export type Pane = "left" | "right" | "foot" | "outline" | "node" | "split";

/** Of each pane: what it has at first, least and most; the first three in pixels, the others as a part of what they share [%]. */
const ROOM: Record<Pane, readonly [number, number, number]> = {
  left: [260, 150, 620],
  right: [330, 220, 760],
  foot: [168, 90, 620],
  outline: [60, 15, 85],
  node: [75, 15, 90],
  split: [50, 20, 80],
};
const KEY = "grip.panes";

interface PanesStore {
  readonly sizes: Readonly<Record<Pane, number>>;
  readonly hidden: ReadonlySet<Pane>;
  resize(pane: Pane, size: number): void;
  /** Put a pane away, or bring it back. */
  toggle(pane: Pane, hidden?: boolean): void;
}

function kept(): Pick<PanesStore, "sizes" | "hidden"> {
  let known: { sizes?: Partial<Record<Pane, unknown>>; hidden?: unknown } = {};
  try {
    known = JSON.parse(localStorage.getItem(KEY) ?? "{}") as typeof known;
  } catch {
    // What can't be read is as if it had never been.
  }
  const size = (pane: Pane): number => within(pane, Number(known.sizes?.[pane] ?? ROOM[pane][0]));
  const sizes = Object.fromEntries(Object.keys(ROOM).map((pane) => [pane, size(pane as Pane)])) as Record<Pane, number>;
  return { sizes, hidden: new Set(Array.isArray(known.hidden) ? (known.hidden.filter((pane) => String(pane) in ROOM) as Pane[]) : []) };
}

function within(pane: Pane, size: number): number {
  const [first, least, most] = ROOM[pane];
  return Number.isFinite(size) ? Math.min(most, Math.max(least, Math.round(size))) : first;
}

export const usePanes = create<PanesStore>()((set) => ({
  ...kept(),
  resize: (pane, size) => set(({ sizes, hidden }) => ({ sizes: { ...sizes, [pane]: within(pane, size) }, hidden: new Set([...hidden].filter((each) => each !== pane)) })),
  toggle: (pane, away) =>
    set(({ hidden }) => {
      const next = new Set(hidden);
      if (away ?? !next.has(pane)) next.add(pane);
      else next.delete(pane);
      return { hidden: next };
    }),
}));

usePanes.subscribe(({ sizes, hidden }) => localStorage.setItem(KEY, JSON.stringify({ sizes, hidden: [...hidden] })));

/** Give a pane more room, or less, by a step. */
export function widen(pane: Pane, by: number): void {
  const { sizes, resize } = usePanes.getState();
  resize(pane, sizes[pane] + by);
}

/** All panes as they were at first. */
export function resetPanes(): void {
  localStorage.removeItem(KEY);
  usePanes.setState(kept());
}
