/** A chart in which a person has put nodes somewhere: those never move, the others make room, and edges find new ways. */
import { type Flow, type FlowItem, LEAD, PORT_HEIGHT } from "./flow";
import { labelWidth, type Level, type Line, OPEN_TOP } from "./flowElk";
import { goesThrough, type Obstacle, routes, type Wanted } from "./flowRoute";
import type { Box, Point } from "./layout";

const GAP = 24;
export type Pins = Readonly<Record<string, readonly [number, number] | number[]>>;

/** Where the origin of a chart stands in the box in which it is open: about where the same chart alone begins. */
const IN_BOX: Point = { x: -26, y: OPEN_TOP - 8 };

/** @param open whether the chart stands in a box, which then holds all of it. */
export function withPins(level: Level, flow: Flow, pins: Pins, inside: ReadonlyMap<string, Level>, open: boolean): { level: Level; origin: Point } {
  const base = open ? IN_BOX : { x: 0, y: 0 };
  const stand = flow.items.filter((item) => level.boxes.has(item.id));
  if (stand.every((item) => pins[item.id] === undefined)) return { level, origin: base };
  const words = wordsOf(flow);
  const boxes = new Map<string, Obstacle>();
  const room = (box: Box, id: string): Obstacle => ({ ...box, words: words.get(id) ?? 0 });
  for (const { id } of stand) {
    const [x, y] = pins[id] ?? [];
    if (x !== undefined && y !== undefined) boxes.set(id, room({ ...(level.boxes.get(id) as Box), x: x + base.x, y: y + base.y }, id));
  }
  const free = stand.filter((item) => !boxes.has(item.id)).map(({ id }) => ({ id, box: level.boxes.get(id) as Box }));
  free.sort((a, b) => a.box.x - b.box.x || a.box.y - b.box.y);
  for (const { id, box } of free) boxes.set(id, makeRoom(room(box, id), boxes));
  const all = [...boxes.values()];
  const by = open ? { x: Math.max(0, 26 - Math.min(...all.map((box) => box.x))), y: Math.max(0, OPEN_TOP - Math.min(...all.map((box) => box.y))) } : { x: 0, y: 0 };
  const moved = new Map([...boxes].map(([id, box]) => [id, { ...box, x: box.x + by.x, y: box.y + by.y }]));
  const border = open ? borderOf(level, moved, by) : level;
  return { level: { ...border, boxes: moved, lines: linesOf(level, flow, moved, border, inside, by) }, origin: { x: base.x + by.x, y: base.y + by.y } };
}

/** Room right of each box for the words on its edges. */
function wordsOf(flow: Flow): ReadonlyMap<string, number> {
  const words = new Map<string, number>();
  for (const edge of flow.edges) if (edge.label) words.set(edge.source, Math.max(words.get(edge.source) ?? 0, labelWidth(edge.label)));
  return words;
}

/** The box, moved down until it overlaps none of the others. */
function makeRoom(box: Obstacle, others: ReadonlyMap<string, Obstacle>): Obstacle {
  let y = box.y;
  for (let moved = true; moved; ) {
    moved = false;
    for (const other of others.values()) {
      const beside = box.x + box.width + box.words + GAP <= other.x || other.x + other.width + other.words + GAP <= box.x;
      if (beside || y + box.height + GAP <= other.y || other.y + other.height + GAP <= y) continue;
      y = other.y + other.height + GAP;
      moved = true;
    }
  }
  return { ...box, y };
}

/** The container around it: as large as what is inside, its outcomes in their order on its border. */
function borderOf(level: Level, boxes: ReadonlyMap<string, Obstacle>, by: Point): Level {
  const all = [...boxes.values()];
  const width = Math.max(...all.map((box) => box.x + box.width + box.words)) + 40;
  let last = OPEN_TOP - PORT_HEIGHT;
  const ports = new Map<string, Point>();
  for (const [outcome, { y }] of [...level.ports].sort((a, b) => a[1].y - b[1].y)) {
    if (outcome === "") ports.set("", { x: 0, y: Math.max(LEAD, y + by.y) });
    else ports.set(outcome, { x: width, y: (last = Math.max(last + PORT_HEIGHT, y + by.y)) });
  }
  const low = Math.max(last, ports.get("")?.y ?? 0, ...all.map((box) => box.y + box.height));
  return { ...level, ports, width, height: low + 26 };
}

function linesOf(level: Level, flow: Flow, boxes: ReadonlyMap<string, Obstacle>, border: Level, inside: ReadonlyMap<string, Level>, by: Point): Map<string, Line> {
  const items = new Map(flow.items.map((item) => [item.id, item]));
  const obstacles = [...boxes.values()];
  const lines = new Map<string, Line>();
  const wanted: [string, Wanted][] = [];
  const same = (id: string): boolean => {
    const [now, before] = [boxes.get(id), level.boxes.get(id)];
    return now !== undefined && before !== undefined && now.x === before.x + by.x && now.y === before.y + by.y;
  };
  for (const edge of flow.edges) {
    const old = level.lines.get(edge.id);
    const points = old?.points.map(({ x, y }) => ({ x: x + by.x, y: y + by.y })) ?? [];
    if (old && same(edge.source) && same(edge.target) && !obstacles.some((box) => goesThrough(points, { ...box, width: box.width + box.words }) && !own(edge, box, boxes))) {
      lines.set(edge.id, { points, label: old.label && { x: old.label.x + by.x, y: old.label.y + by.y } });
      continue;
    }
    const from = leaves(items.get(edge.source) as FlowItem, edge.outcome, boxes, border, inside);
    const to = enters(items.get(edge.target) as FlowItem, boxes, border, inside);
    wanted.push([edge.id, { from, to, words: edge.label ? labelWidth(edge.label) : 0, target: edge.target }]);
  }
  const found = routes(wanted.map(([, each]) => each), obstacles);
  for (const [i, [id, { from, words }]] of wanted.entries()) {
    lines.set(id, { points: found[i] as Point[], label: words ? { x: from.x + 6 + words / 2, y: from.y } : null });
  }
  return lines;
}

/** The words right of its own source are where an edge begins. */
const own = (edge: { source: string; target: string }, box: Obstacle, boxes: ReadonlyMap<string, Obstacle>): boolean => boxes.get(edge.source) === box || boxes.get(edge.target) === box;

function leaves(item: FlowItem, outcome: string, boxes: ReadonlyMap<string, Obstacle>, border: Level, inside: ReadonlyMap<string, Level>): Point {
  const box = boxes.get(item.id);
  if (box === undefined) return border.ports.get("") as Point;
  if (item.kind === "start") return { x: box.x + box.width, y: box.y + box.height / 2 };
  const i = item.ports.findIndex((port) => port.outcome === outcome);
  return { x: box.x + box.width, y: box.y + (inside.get(item.id)?.ports.get(outcome)?.y ?? LEAD + Math.max(0, i) * PORT_HEIGHT) };
}

function enters(item: FlowItem, boxes: ReadonlyMap<string, Obstacle>, border: Level, inside: ReadonlyMap<string, Level>): Point {
  const box = boxes.get(item.id);
  if (box === undefined) return border.ports.get(item.outcome ?? "") as Point;
  return { x: box.x, y: box.y + (item.kind === "end" ? box.height / 2 : (inside.get(item.id)?.ports.get("")?.y ?? LEAD)) };
}
