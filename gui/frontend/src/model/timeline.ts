/** How a run's robot has moved: pieces of its record put together, and where everything was at a time. */
import type { MeshView, MotionView, RunEvent, SceneItem } from "../protocol/generated";
import type { Phase, TaskIndex } from "./status";

/** Where everything is at one time. */
export interface Stand {
  readonly t: number;
  /** Joint -> position [rad or m]. */
  readonly joints: ReadonlyMap<string, number>;
  readonly scene: Readonly<Record<string, SceneItem>>;
  /** What meshes and maps of cells look like. */
  readonly bodies: Readonly<Record<string, MeshView>>;
  /** The ways that were gone last, the newest one first. */
  readonly ways: readonly Way[];
  /** What is planned and not begun, the next one first. */
  readonly plans: readonly Way[];
  /** Link that touches something -> contact force [N]. */
  readonly touch: ReadonlyMap<string, number>;
  readonly press: readonly Press[];
  /** The largest force of all the record so far [N], at one point. */
  readonly hardest: number;
}

/** Where a link presses on something. */
export interface Press {
  readonly link: string;
  readonly other: string;
  /** In the world [m]. */
  readonly at: readonly number[];
  /** On what is pressed [N]. */
  readonly force: readonly number[];
}

/** Where an arm was to go: positions of its joints, one after the other. */
export interface Way {
  readonly arm: string;
  readonly over: boolean;
  readonly points: readonly ReadonlyMap<string, number>[];
}

/** How far along a way joints are, counted in its points: where it comes nearest to them. */
export function along(points: Way["points"], joints: ReadonlyMap<string, number>): number {
  let [best, nearest] = [0, Number.POSITIVE_INFINITY];
  points.slice(1).forEach((to, at) => {
    const steps = [...(points[at] ?? [])].map(([joint, from]) => [(to.get(joint) ?? from) - from, (joints.get(joint) ?? from) - from] as const);
    const length = steps.reduce((sum, [step]) => sum + step * step, 0);
    const part = length === 0 ? 0 : Math.min(1, Math.max(0, steps.reduce((sum, [step, gone]) => sum + step * gone, 0) / length));
    const off = steps.reduce((sum, [step, gone]) => sum + (gone - part * step) ** 2, 0);
    if (off < nearest) [best, nearest] = [at + part, off];
  });
  return best;
}

/** How long the arrow of `newtonsOf` is [m], and the longest one is at most [m]. */
export const REACH = 0.05;
const LONGEST = 0.12;

/** How many newtons an arrow of `REACH` stands for: 1, 2 or 5 of a power of ten, so that the hardest contact fits. */
export function newtonsOf(hardest: number): number {
  const least = Math.max(hardest, 0.1) * (REACH / LONGEST);
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((step) => step * power).find((newtons) => newtons >= least * (1 - 1e-9)) ?? 10 * power;
}

/** So many ways are remembered at a time: today's, and some that fade. */
const WAYS = 3;

interface Known {
  readonly t: number;
  readonly q: Readonly<Record<string, readonly number[]>>;
  readonly scene: Readonly<Record<string, SceneItem>>;
  readonly ways: readonly Way[];
  readonly plans: Readonly<Record<string, readonly Way[]>>;
  readonly touch: Readonly<Record<string, Readonly<Record<string, number>>>>;
  readonly press: readonly Press[];
}

export class Motion {
  private parts: Readonly<Record<string, readonly string[]>> = {};
  private readonly known: Known[] = [];
  private readonly bodies: Record<string, MeshView> = {};
  /** Where to go on reading. */
  next = 0;
  private hardest = 0;

  get length(): number {
    return this.known.length;
  }

  /** Take the next piece of the record. */
  add(piece: MotionView): void {
    if (Object.keys(piece.parts).length > 0) this.parts = piece.parts;
    Object.assign(this.bodies, piece.bodies);
    for (const sample of piece.samples) {
      const before = this.known.at(-1);
      const told = Object.entries(sample.way);
      const begun = told.filter(([, points]) => points.length > 0).map(([arm, points]) => this.way(arm, points));
      const gone = told.length === 0 ? (before?.ways ?? []) : (before?.ways ?? []).map((way) => (way.arm in sample.way && !way.over ? { ...way, over: true } : way));
      const planned = Object.entries(sample.plans).map(([arm, plans]) => [arm, plans.map((points) => this.way(arm, points))]);
      const press = sample.press && Object.values(sample.press).flatMap((points) => points.map(([link, other, at, force]) => ({ link, other, at, force })));
      for (const { force } of press ?? []) this.hardest = Math.max(this.hardest, Math.hypot(...force));
      this.known.push({
        t: sample.t,
        q: { ...before?.q, ...sample.q },
        scene: sample.scene ?? before?.scene ?? {},
        ways: begun.length > 0 ? [...begun, ...gone].slice(0, WAYS) : gone,
        plans: planned.length > 0 ? { ...before?.plans, ...Object.fromEntries(planned) } : (before?.plans ?? {}),
        touch: sample.touch ?? before?.touch ?? {},
        press: press ?? before?.press ?? [],
      });
    }
    this.next = piece.next;
  }

  private way(arm: string, points: readonly (readonly number[])[]): Way {
    return { arm, over: false, points: points.map((point) => new Map((this.parts[arm] ?? []).map((joint, at) => [joint, point[at] ?? 0]))) };
  }

  /** What was true at a time: the last sample not after it, the first where there is none, null without any. */
  at(t: number): Stand | null {
    let low = 0;
    let high = this.known.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if ((this.known[middle] as Known).t <= t) low = middle + 1;
      else high = middle;
    }
    const found = this.known[Math.max(0, low - 1)];
    if (!found) return null;
    const joints = new Map<string, number>();
    for (const [part, names] of Object.entries(this.parts)) names.forEach((name, at) => found.q[part]?.[at] !== undefined && joints.set(name, found.q[part]?.[at] as number));
    const touch = new Map(Object.values(found.touch).flatMap((links) => Object.entries(links)));
    return { t: found.t, joints, scene: found.scene, bodies: this.bodies, ways: found.ways, plans: Object.values(found.plans).flat(), touch, press: found.press, hardest: this.hardest };
  }
}

export interface Span {
  readonly path: string;
  readonly from: number;
  readonly to: number | null;
  readonly phase: Phase;
  readonly lane: number;
}

/** Bars in the order of their start; those that overlap get different lanes. */
export function spansOf(events: readonly RunEvent[], index: TaskIndex): Span[] {
  const spans: Span[] = [];
  const open = new Map<string, number>();
  const lanes: (string | null)[] = [];
  const close = (path: string, to: number, phase: Phase): void => {
    const at = open.get(path);
    if (at === undefined) return;
    const span = spans[at] as Span;
    spans[at] = { ...span, to, phase };
    lanes[span.lane] = null;
    open.delete(path);
  };
  for (const event of events) {
    if (index.byPath.get(event.path)?.kind !== "leaf") continue;
    if (event.event === "enter" || (event.event === "went_on" && !open.has(event.path))) {
      close(event.path, event.t, "ended");
      const free = lanes.indexOf(null);
      const lane = free < 0 ? lanes.length : free;
      lanes[lane] = event.path;
      open.set(event.path, spans.length);
      spans.push({ path: event.path, from: event.t, to: null, phase: "running", lane });
    } else if (event.event === "exit") {
      close(event.path, event.t, index.phaseOf(event.path, event.outcome));
    } else if (event.event === "interrupted" || event.event === "error") {
      close(event.path, event.t, event.event);
    }
  }
  return spans;
}
