/** Ways for edges round boxes that a person has put somewhere: the shortest with few corners, level and upright pieces alone. */
import type { Box, Point } from "./layout";

/** What an edge has to go round; the words beside a box's outcomes are part of it. */
export interface Obstacle extends Box {
  /** Room that words need right of it. */
  readonly words: number;
}

export interface Wanted {
  readonly from: Point;
  /** Room for its words: so far it goes straight ahead. */
  readonly words: number;
  readonly to: Point;
  /** Edges to one target may share their way. */
  readonly target: string;
}

const MARGIN = 12;
/** A corner costs as much as so long a way [px]. */
const CORNER = 40;
/** Beside each border there are so many tracks, for edges to several targets. */
const TRACKS = [0, 9, 18];
const FEW = 40;

/** Ways for all that is wanted, one after another; each keeps off what the ones before have taken. */
export function routes(wanted: readonly Wanted[], obstacles: readonly Obstacle[]): Point[][] {
  const maze = new Maze(wanted, obstacles);
  return wanted.map((edge) => maze.way(edge) ?? elbow(edge));
}

const beginOf = ({ from, words }: Wanted): Point => ({ x: from.x + words + MARGIN, y: from.y });
const endOf = ({ to }: Wanted): Point => ({ x: to.x - MARGIN, y: to.y });

/** Where there is no way (boxes that were put on each other): straight, with two corners. */
function elbow(edge: Wanted): Point[] {
  const [a, b] = [beginOf(edge), endOf(edge)];
  const middle = Math.max(a.x, (a.x + b.x) / 2);
  return tidied([edge.from, a, { x: middle, y: a.y }, { x: middle, y: b.y }, b, edge.to]);
}

class Maze {
  private readonly xs: number[];
  private readonly ys: number[];
  /** Whether the piece from a crossing to the next one, to the right and down, is inside an obstacle. */
  private readonly level: Uint8Array;
  private readonly upright: Uint8Array;
  /** Which target's edges run along a piece. */
  private readonly taken = new Map<number, string>();

  constructor(wanted: readonly Wanted[], obstacles: readonly Obstacle[]) {
    const rooms = obstacles.map((box) => ({ left: box.x - MARGIN, right: box.x + box.width + box.words + MARGIN, top: box.y - MARGIN, bottom: box.y + box.height + MARGIN }));
    const tracks = obstacles.length > FEW ? [0] : TRACKS;
    const sorted = (all: number[]): number[] => [...new Set(all)].sort((a, b) => a - b);
    const ends = wanted.flatMap((edge) => [beginOf(edge), endOf(edge)]);
    this.xs = sorted([...ends.map((end) => end.x), ...rooms.flatMap((room) => tracks.flatMap((by) => [room.left - by, room.right + by]))]);
    this.ys = sorted([...ends.map((end) => end.y), ...rooms.flatMap((room) => tracks.flatMap((by) => [room.top - by, room.bottom + by]))]);
    const [width, height] = [this.xs.length, this.ys.length];
    this.level = new Uint8Array(width * height);
    this.upright = new Uint8Array(width * height);
    for (const { left, right, top, bottom } of rooms) {
      const [x0, x1] = [this.xs.indexOf(left), this.xs.indexOf(right)];
      const [y0, y1] = [this.ys.indexOf(top), this.ys.indexOf(bottom)];
      for (let y = y0; y <= y1; y++) {
        for (let x = x0; x <= x1; x++) {
          if (y > y0 && y < y1 && x < x1) this.level[y * width + x] = 1;
          if (x > x0 && x < x1 && y < y1) this.upright[y * width + x] = 1;
        }
      }
    }
  }

  way(edge: Wanted): Point[] | null {
    const width = this.xs.length;
    const cell = ({ x, y }: Point): number => this.ys.indexOf(y) * width + this.xs.indexOf(x);
    const [begin, end] = [beginOf(edge), endOf(edge)];
    const cells = this.search(cell(begin), cell(end), edge.target);
    if (cells === null) return null;
    cells.slice(1).forEach((to, i) => this.taken.set(this.piece(cells[i] as number, to), edge.target));
    const points = cells.map((at) => ({ x: this.xs[at % width] as number, y: this.ys[Math.floor(at / width)] as number }));
    return tidied([edge.from, ...points, edge.to]);
  }

  private piece(a: number, b: number): number {
    return Math.min(a, b) * 2 + (Math.abs(a - b) === 1 ? 0 : 1);
  }

  /** The cheapest way by A*; a state is a crossing with the direction in which it was come to (0 level, 1 upright). */
  private search(begin: number, end: number, target: string): number[] | null {
    const width = this.xs.length;
    const count = width * this.ys.length;
    const x = (at: number): number => this.xs[at % width] as number;
    const y = (at: number): number => this.ys[Math.floor(at / width)] as number;
    const cost = new Float64Array(count * 2).fill(Infinity);
    const before = new Int32Array(count * 2).fill(-1);
    const queue = new Queue();
    const left = (at: number): number => Math.abs(x(at) - x(end)) + Math.abs(y(at) - y(end));
    cost[begin * 2] = 0;
    queue.put(begin * 2, left(begin));
    for (let state = queue.take(); state !== undefined; state = queue.take()) {
      const at = state >> 1;
      if (at === end && (state & 1) === 0) return this.back(state, before);
      for (const [by, upright] of [[1, 0], [-1, 0], [width, 1], [-width, 1]] as const) {
        const to = at + by;
        if (to < 0 || to >= count || (upright === 0 && Math.floor(to / width) !== Math.floor(at / width))) continue;
        if ((upright ? this.upright : this.level)[Math.min(at, to)]) continue;
        const owner = this.taken.get(this.piece(at, to));
        const length = Math.abs(x(at) - x(to)) + Math.abs(y(at) - y(to));
        // It leaves and arrives to the right: what turns round at once looks like an edge of its neighbour.
        const turn = upright !== (state & 1) ? CORNER : 0;
        const now = (cost[state] as number) + length * (owner === undefined || owner === target ? 1 : 4) + turn;
        const next = to * 2 + upright;
        if (now >= (cost[next] as number)) continue;
        cost[next] = now;
        before[next] = state;
        queue.put(next, now + left(to));
      }
    }
    return null;
  }

  private back(last: number, before: Int32Array): number[] {
    const cells: number[] = [];
    for (let state = last; state >= 0; state = before[state] as number) cells.unshift(state >> 1);
    return cells;
  }
}

/** A heap: the cheapest first. */
class Queue {
  private readonly heap: [number, number][] = [];

  put(state: number, cost: number): void {
    const { heap } = this;
    let at = heap.push([state, cost]) - 1;
    for (let up = (at - 1) >> 1; at > 0 && (heap[up] as [number, number])[1] > cost; up = (at - 1) >> 1) {
      this.swap(at, up);
      at = up;
    }
  }

  take(): number | undefined {
    const { heap } = this;
    const first = heap[0]?.[0];
    const last = heap.pop();
    if (heap.length === 0 || last === undefined) return first;
    heap[0] = last;
    for (let at = 0; ; ) {
      const cost = (i: number): number => heap[i]?.[1] ?? Infinity;
      const down = cost(2 * at + 1) <= cost(2 * at + 2) ? 2 * at + 1 : 2 * at + 2;
      if (cost(down) >= cost(at)) return first;
      this.swap(at, down);
      at = down;
    }
  }

  private swap(a: number, b: number): void {
    [this.heap[a], this.heap[b]] = [this.heap[b] as [number, number], this.heap[a] as [number, number]];
  }
}

/** Without points on a straight piece. */
export function tidied(points: readonly Point[]): Point[] {
  const kept: Point[] = [];
  for (const point of points) {
    const [a, b] = [kept.at(-2), kept.at(-1)];
    if (b && b.x === point.x && b.y === point.y) continue;
    if (a && b && ((a.x === b.x && b.x === point.x) || (a.y === b.y && b.y === point.y))) kept.pop();
    kept.push(point);
  }
  return kept;
}

/** Whether a way of level and upright pieces goes through a box, by more than its border. */
export function goesThrough(points: readonly Point[], box: Box): boolean {
  return points.slice(1).some((b, i) => {
    const a = points[i] as Point;
    return Math.max(a.x, b.x) > box.x + 1 && Math.min(a.x, b.x) < box.x + box.width - 1 && Math.max(a.y, b.y) > box.y + 1 && Math.min(a.y, b.y) < box.y + box.height - 1;
  });
}
