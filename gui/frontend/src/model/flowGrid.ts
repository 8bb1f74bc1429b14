/** A chart with more nodes than a layered layout can take: rows in reading order, edges in the lanes between them. */
import { type Flow, type FlowItem, LEAD, PORT_HEIGHT, readingOrder } from "./flow";
import { labelWidth, type Level, type Line, OPEN_TOP } from "./flowElk";
import { tidied } from "./flowRoute";
import type { Box, Point } from "./layout";

/** Lanes between rows and columns: edges to one target share one. */
const LANES = 6;
const LANE = 8;
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
