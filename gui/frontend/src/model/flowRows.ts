/** Charts that are too long for one line, in rows as text is; and those that are too large for a layered layout, in a grid. */
import { type Flow, type FlowItem, isStart, LEAD, PORT_HEIGHT, readingOrder } from "./flow";
import { enteredFor, freeRoom, labelWidth, leftFor, type Level, type Line, OPEN_TOP } from "./flowElk";
import { tidied } from "./flowRoute";
import type { Box, Point } from "./layout";

/** What a page of 1280 x 720 with all its panes shows of a chart at a size at which all of it can be read [px of the chart]. */
const ROOM = { width: 874, height: 664 };
/** Between what stands in a row and the lanes beside it, between lanes, and for a corner with an arrow before a box. */
const GAP = 12;
const LANE = 10;
const ARROW = 20;
/** What rows take beside their nodes: the ends, and lanes on both sides; and below them: edges aside, and lanes. */
const BESIDE = 165;
const BELOW = 50;
/** Between ends, which are so high. */
const END_STEP = 48;
/** Between layers, and between what stands above one another. */
const BETWEEN = 24;
const ABOVE = 28;
/** So much larger a chart in rows has to be seen for it. */
const WORTH = 1.1;
/** Rows that are so much wider are tried next, where those before are too many. */
const WIDER = 1.1;
/** Such a part of a row is full at least, if it could be: a better place to end it is looked for in the rest. */
const FULL = 0.6;

/** How large a chart is seen as a whole, up to the size at which all of it can be read: 1. */
const seen = ({ width, height }: { width: number; height: number }): number => Math.min(1, ROOM.width / width, ROOM.height / height);

/**
 * What stands in each row of a chart, where that is worth while; else none. Rows are filled from above, so that a change moves
 * little before it.
 * @param inside levels of the containers that are open in it.
 * @param open the container's own box, where it is open in another chart.
 */
export function rowsOf(flow: Flow, inside: ReadonlyMap<string, Level>, open: FlowItem | null): ReadonlySet<string>[] {
  const layers = layersOf(flow, inside, open);
  const size = (rows: readonly Layer[][]): number =>
    seen({
      width: BESIDE + Math.max(...rows.map(widthOf)),
      height: rows.reduce((sum, row) => sum + BELOW + Math.max(...row.map((layer) => layer.height)), 0),
    });
  if (layers.length === 0) return [];
  const across = acrossBefore(flow, layers);
  let best: Layer[][] = [];
  let most = size([layers]) * WORTH;
  for (let width = ROOM.width - BESIDE; width < widthOf(layers) && most < 1; width *= WIDER) {
    const rows = filled(layers, across, width);
    if (size(rows) > most) [best, most] = [rows, size(rows)];
  }
  return best.map((row) => new Set(row.flatMap((layer) => layer.ids)));
}

const widthOf = (row: readonly Layer[]): number => (row.at(-1) as Layer).right - (row[0] as Layer).left;

/** What stands above one another, about as the layout will have it. */
interface Layer {
  readonly ids: string[];
  readonly left: number;
  readonly right: number;
  readonly height: number;
}

/** Each node stands right of all from which edges lead ahead to it. The ends of the chart stand beside its rows. */
function layersOf(flow: Flow, inside: ReadonlyMap<string, Level>, open: FlowItem | null): Layer[] {
  const items = new Map(flow.items.filter((item) => item.kind === "node" || (item.kind === "start" && open === null)).map((item) => [item.id, item]));
  const start = flow.edges.find((edge) => isStart(edge.source));
  const order = readingOrder([...items.keys()], flow.edges, open === null ? start?.source : start?.target);
  const place = new Map(order.map((id, i) => [id, i]));
  const layerOf = new Map<string, number>();
  for (const id of order) {
    const before = flow.edges.filter((edge) => edge.target === id && (place.get(edge.source) ?? Infinity) < (place.get(id) as number));
    layerOf.set(id, Math.max(-1, ...before.map((edge) => layerOf.get(edge.source) as number)) + 1);
  }
  const words = new Map<string, number>();
  for (const { source, label } of flow.edges) if (label) words.set(source, Math.max(words.get(source) ?? 0, labelWidth(label)));
  const size = (id: string): { width: number; height: number } => inside.get(id) ?? (items.get(id) as FlowItem);
  let x = 0;
  return Array.from({ length: Math.max(-1, ...layerOf.values()) + 1 }, (_, i) => {
    const ids = order.filter((id) => layerOf.get(id) === i);
    const left = x;
    const right = left + Math.max(...ids.map((id) => size(id).width + (words.get(id) ?? 0)));
    x = right + BETWEEN;
    return { ids, left, right, height: ids.reduce((sum, id) => sum + size(id).height, 0) + (ids.length - 1) * ABOVE };
  });
}

/** To how many nodes edges lead across the place before each layer. */
function acrossBefore(flow: Flow, layers: readonly Layer[]): number[] {
  const at = new Map(layers.flatMap(({ ids }, i) => ids.map((id) => [id, i])));
  const edges = flow.edges.filter(({ target }) => at.has(target)).map(({ source, target }) => ({ target, from: at.get(source) ?? 0, to: at.get(target) as number }));
  return layers.map((_, i) => new Set(edges.filter(({ from, to }) => from < i !== to < i).map(({ target }) => target)).size);
}

/** Rows up to a width, each ended where the fewest edges go on to others. */
function filled(layers: readonly Layer[], across: readonly number[], width: number): Layer[][] {
  const rows: Layer[][] = [];
  const until = (from: number, to: number): number => widthOf(layers.slice(from, to));
  for (let from = 0, end = 0; from < layers.length; from = end) {
    end = from + 1;
    while (end < layers.length && until(from, end + 1) <= width) end++;
    if (end < layers.length) {
      for (let at = end - 1; at > from && until(from, at) >= width * FULL; at--) if ((across[at] as number) < (across[end] as number)) end = at;
    }
    rows.push(layers.slice(from, end));
  }
  return rows;
}

/** A row, and where it stands. */
interface Row {
  readonly level: Level;
  readonly top: number;
  /** The nodes in other rows to which it leads, by the lanes below it, from above. */
  readonly to: readonly string[];
}

/** What is right of the rows: an end, or where it is on the border of the container. */
interface Out {
  readonly end: FlowItem;
  readonly y: number;
}

/** Where edges go that don't stay within a row. */
interface Lanes {
  /** Where rows begin, and where the lanes begin that are right of all of them. */
  readonly left: number;
  readonly right: number;
  /** Left of the rows, for each node that is led to from another row. */
  readonly into: ReadonlyMap<string, number>;
  readonly outs: readonly Out[];
  /** Where the ends begin. */
  readonly border: number;
}

/**
 * Rows below one another. What leads from one to another goes down right of it, to the left below it, and left of all to
 * where it is wanted: no box and no words are there. Ends stand right of the rows, beside the last that leads to them.
 * @param levels of the rows.
 * @param open the container's own box, where it is open in another chart.
 */
export function inRows(flow: Flow, levels: readonly Level[], open: FlowItem | null): Level {
  const ends = flow.items.filter((item) => item.kind === "end");
  const rows = stacked(levels, new Set(ends.map((end) => end.id)), open ? OPEN_TOP : 8);
  const into = lanesOf(rows);
  const left = (open ? 26 : 8) + (into.size > 0 ? ARROW + Math.max(...into.values()) * LANE : 0);
  const right = Math.max(...rows.map(({ level, to }) => left + level.width + to.length * LANE)) + GAP;
  const border = right + (ends.length - 1) * LANE + ARROW + (open ? freeRoom(open) : 0);
  const outs = outsOf(ends, rows, open !== null);
  const boxes = new Map(rows.flatMap(({ level, top }) => [...level.boxes].map(([id, box]) => [id, { ...box, x: box.x + left, y: box.y + top }] as const)));
  const lines = linesOf(flow, rows, { left, right, into, outs, border });
  const last = rows.at(-1) as Row;
  const low = Math.max(bottomOf(last) + last.to.length * LANE, ...outs.map(({ end, y }) => y + (open ? 0 : end.height / 2)));
  if (open) {
    const start = flow.edges.find((edge) => isStart(edge.source));
    const entry = { x: 0, y: (start && lines.get(start.id)?.points[0]?.y) ?? OPEN_TOP + LEAD };
    const ports = new Map([["", entry], ...outs.map(({ end, y }) => [end.outcome ?? "", { x: border, y }] as const)]);
    return { boxes, lines, ports, width: border, height: low + 18 };
  }
  for (const { end, y } of outs) boxes.set(end.id, { x: border, y: y - end.height / 2, width: end.width, height: end.height });
  return { boxes, lines, ports: new Map(), width: border + Math.max(0, ...ends.map((end) => end.width)) + 8, height: low + 8 };
}

const bottomOf = ({ level, top }: Row): number => top + level.height;
/** The lane below a row in which it leads to a node. */
const laneBelow = (row: Row, target: string): number => bottomOf(row) + GAP + row.to.indexOf(target) * LANE;

function stacked(levels: readonly Level[], ends: ReadonlySet<string>, begin: number): Row[] {
  let top = begin;
  return levels.map((level) => {
    const left = [...level.ports].map(([name, { y }]) => ({ id: name.slice(1), y, out: name === leftFor(name.slice(1)) })).filter(({ id, out }) => out && !ends.has(id));
    const row = { level, top, to: left.sort((a, b) => b.y - a.y).map(({ id }) => id) };
    top = bottomOf(row) + row.to.length * LANE + 2 * GAP;
    return row;
  });
}

/** Lanes left of the rows, counted from them: those of the shortest ways are next to them. */
function lanesOf(rows: readonly Row[]): ReadonlyMap<string, number> {
  const spans = [...new Set(rows.flatMap((row) => row.to))].map((id) => {
    const ys = rows.flatMap((row) => {
      const entry = row.level.ports.get(enteredFor(id));
      return [...(entry ? [row.top + entry.y] : []), ...(row.to.includes(id) ? [laneBelow(row, id)] : [])];
    });
    return { id, top: Math.min(...ys), bottom: Math.max(...ys) };
  });
  spans.sort((a, b) => a.bottom - a.top - (b.bottom - b.top));
  const taken: (typeof spans)[] = [];
  const lanes = new Map<string, number>();
  for (const span of spans) {
    const free = taken.findIndex((lane) => lane.every((other) => other.bottom + LANE < span.top || span.bottom + LANE < other.top));
    const lane = free < 0 ? taken.push([]) - 1 : free;
    (taken[lane] as typeof spans).push(span);
    lanes.set(span.id, lane);
  }
  return lanes;
}

/** The ends with their heights: beside the last row that leads to each, as near as the room between them allows. */
function outsOf(ends: readonly FlowItem[], rows: readonly Row[], open: boolean): Out[] {
  const outs = ends.map((end) => {
    const from = rows.findLast(({ level }) => level.ports.has(leftFor(end.id)));
    return { end, y: from ? from.top + (from.level.ports.get(leftFor(end.id)) as Point).y : Infinity };
  });
  // On the border of a container outcomes have an order.
  if (!open) outs.sort((a, b) => a.y - b.y);
  let last = -Infinity;
  return outs.map(({ end, y }) => {
    last = Math.max(last + (open ? PORT_HEIGHT : END_STEP), y === Infinity ? (rows.at(-1) as Row).top + LEAD : y);
    return { end, y: last };
  });
}

function linesOf(flow: Flow, rows: readonly Row[], lanes: Lanes): Map<string, Line> {
  const rowOf = new Map(rows.flatMap((row) => [...row.level.boxes.keys()].map((id) => [id, row])));
  const lines = new Map<string, Line>();
  for (const edge of flow.edges) {
    const [from, to] = [rowOf.get(edge.source), rowOf.get(edge.target)];
    const moved = (row: Row, { x, y }: Point): Point => ({ x: x + lanes.left, y: y + row.top });
    const begins = from?.level.lines.get(edge.id)?.points.map((point) => moved(from, point)) ?? [];
    const arrives = from === to ? [] : (to?.level.lines.get(enteredFor(edge.target))?.points.map((point) => moved(to, point)) ?? []);
    const way = from === undefined ? [{ x: 0, y: arrives[0]?.y ?? 0 }] : from === to ? [] : between(edge.target, from, begins.at(-1)?.y ?? 0, arrives[0]?.y ?? 0, lanes);
    const words = from?.level.lines.get(edge.id)?.label;
    lines.set(edge.id, { points: tidied([...begins, ...way, ...arrives]), label: from && words ? moved(from, words) : null });
  }
  return lines;
}

/** The way from where an edge leaves its row to where it comes into that of its target, or to an end. */
function between(target: string, from: Row, leaves: number, arrives: number, { left, right, into, outs, border }: Lanes): Point[] {
  const out = outs.findIndex(({ end }) => end.id === target);
  if (out >= 0) {
    const x = right + (outs.length - 1 - out) * LANE;
    const { y } = outs[out] as Out;
    return [{ x, y: leaves }, { x, y }, { x: border, y }];
  }
  const x = left + from.level.width + from.to.indexOf(target) * LANE;
  const low = laneBelow(from, target);
  const beside = left - ARROW - (into.get(target) ?? 0) * LANE;
  return [{ x, y: leaves }, { x, y: low }, { x: beside, y: low }, { x: beside, y: arrives }];
}

/** Lanes between rows and columns: edges to one target share one. */
const LANES = 6;

const LANES_WIDE = (LANES + 1) * LANE;

export function gridOf(flow: Flow, inside: ReadonlyMap<string, Level>, open: FlowItem | null): Level {
  const start = flow.items.find((item) => item.kind === "start");
  const items = new Map(flow.items.filter((item) => open === null || item.kind === "node").map((item) => [item.id, item]));
  const order = readingOrder([...items.keys()], flow.edges, start?.id);
  const words = Math.max(0, ...flow.edges.map((edge) => (edge.label ? labelWidth(edge.label) : 0)));
  const columns = Math.max(4, Math.ceil(Math.sqrt(order.length * 1.2)));
  const size = (id: string): { width: number; height: number } => inside.get(id) ?? (items.get(id) as FlowItem);
  const wide = Array.from({ length: columns }, (_, c) => Math.max(0, ...order.filter((_, i) => i % columns === c).map((id) => size(id).width)));
  const boxes = new Map<string, Box>();
  /** Below the boxes of each row: where its lanes begin. */
  const lows: number[] = [];
  let y = OPEN_TOP;
  for (let row = 0; row * columns < order.length; row++) {
    const here = order.slice(row * columns, (row + 1) * columns);
    let x = LANES_WIDE + 8;
    here.forEach((id, c) => {
      boxes.set(id, { x, y, ...pick(size(id)) });
      x += (wide[c] as number) + words + 12 + LANES_WIDE;
    });
    lows.push(y + Math.max(...here.map((id) => size(id).height)));
    y = (lows.at(-1) as number) + LANES_WIDE + 12;
  }
  const width = Math.max(0, ...[...boxes.values()].map((box) => box.x + box.width)) + words + LANES_WIDE + 40;
  const ports = new Map<string, Point>([["", { x: 0, y: OPEN_TOP + LEAD }]]);
  open?.ports.forEach((port, i) => ports.set(port.outcome, { x: width, y: OPEN_TOP + LEAD + i * PORT_HEIGHT }));
  const level = { boxes, ports, width, height: y };
  const targets = new Map(flow.items.map((item, i) => [item.id, i % LANES]));
  const lines = new Map<string, Line>();
  const known = new Map(flow.items.map((item) => [item.id, item]));
  const rank = new Map(order.map((id, i) => [id, i]));
  for (const edge of flow.edges) {
    const [from, to] = [known.get(edge.source), known.get(edge.target)] as [FlowItem, FlowItem];
    const at = rank.get(edge.source) ?? -1;
    const [source, target] = [boxes.get(edge.source), boxes.get(edge.target)];
    const a = source === undefined ? (ports.get("") as Point) : leaves(from, edge.outcome, source, inside.get(edge.source));
    const b = target === undefined ? (ports.get(to.outcome ?? "") as Point) : { x: target.x, y: target.y + (to.kind === "end" ? target.height / 2 : (inside.get(edge.target)?.ports.get("")?.y ?? LEAD)) };
    const lane = ((targets.get(edge.target) as number) + 1) * LANE;
    const out = source === undefined ? a.x + lane : source.x + (wide[at % columns] as number) + words + 8 + lane;
    const low = source === undefined ? OPEN_TOP - 4 : (lows[Math.floor(at / columns)] as number) + lane;
    const into = b.x - LANES_WIDE + lane - 4;
    const next = source !== undefined && target !== undefined && rank.get(edge.target) === at + 1 && target.x > source.x;
    const points = next ? [a, { x: into, y: a.y }, { x: into, y: b.y }, b] : [a, { x: out, y: a.y }, { x: out, y: low }, { x: into, y: low }, { x: into, y: b.y }, b];
    lines.set(edge.id, { points: tidied(points), label: edge.label ? { x: a.x + 6 + labelWidth(edge.label) / 2, y: a.y } : null });
  }
  return { ...level, lines };
}

const pick = ({ width, height }: { width: number; height: number }): { width: number; height: number } => ({ width, height });

function leaves(item: FlowItem, outcome: string, box: Box, level: Level | undefined): Point {
  if (item.kind === "start") return { x: box.x + box.width, y: box.y + box.height / 2 };
  const i = Math.max(0, item.ports.findIndex((port) => port.outcome === outcome));
  return { x: box.x + box.width, y: box.y + (level?.ports.get(outcome)?.y ?? LEAD + i * PORT_HEIGHT) };
}
