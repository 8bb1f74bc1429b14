/** A flow chart with containers open in it: the chart of each stands in its box, laid out by itself. */
import type { NodeView, TaskView } from "../protocol/generated";
import { parentOf } from "./commands";
import { type Flow, type FlowEdge, type FlowItem, flowOf } from "./flow";
import { type Box, type FlowLayout, layoutFlow, type Point } from "./flowLayout";

/** Around a chart that stands in a box. */
const MARGIN = 14;
type Pins = Readonly<Record<string, readonly [number, number] | number[]>>;

export interface PlacedItem {
  readonly item: FlowItem;
  /** The box in which it stands; null in the chart itself. */
  readonly parent: string | null;
  /** Relative to that box. */
  readonly box: Box;
  /** Where the origin of its own chart is, relative to that box: pins are positions in that chart. */
  readonly origin: Point;
}

export interface PlacedEdge extends FlowEdge {
  readonly bends: readonly Point[];
  /** Of an edge to its own node: where that node ends below. */
  readonly bottom: number;
}

export interface FlowChart {
  readonly flow: Flow;
  /** Boxes before what stands in them. */
  readonly items: readonly PlacedItem[];
  readonly edges: readonly PlacedEdge[];
  /** Where everything is on the whole chart. */
  readonly boxes: ReadonlyMap<string, Box>;
}

interface Laid {
  readonly flow: Flow;
  readonly layout: FlowLayout;
  readonly inside: ReadonlyMap<string, Laid>;
  readonly extent: Box;
}

/**
 * The chart of a container.
 * @param opened containers whose inside is shown in place.
 * @param pins positions of pinned nodes, each in the chart of its own container.
 */
export function chartOf(task: TaskView, byPath: ReadonlyMap<string, NodeView>, container: string, opened: ReadonlySet<string>, pins: Pins): FlowChart {
  const lay = (path: string, within: string): Laid => {
    const flow = flowOf(task, byPath, path, within);
    const inside = new Map<string, Laid>();
    const items = flow.items.map((item) => {
      if (item.node === undefined || item.node.children.length === 0 || !opened.has(item.id)) return item;
      const laid = lay(item.id, item.id);
      inside.set(item.id, laid);
      return { ...item, width: Math.max(item.width, laid.extent.width + 2 * MARGIN), height: item.height + laid.extent.height + 2 * MARGIN };
    });
    const layout = layoutFlow({ ...flow, items }, pins);
    return { flow: { ...flow, items }, layout, inside, extent: extentOf(layout.boxes.values()) };
  };
  const whole = lay(container, "");
  const items: PlacedItem[] = [];
  const edges: PlacedEdge[] = [];
  const boxes = new Map<string, Box>();
  const place = (laid: Laid, parent: string | null, origin: Point, dx: number, dy: number): void => {
    for (const item of laid.flow.items) {
      const box = laid.layout.boxes.get(item.id) as Box;
      const here = { ...box, x: box.x + dx, y: box.y + dy };
      items.push({ item, parent, box: here, origin: { x: dx, y: dy } });
      boxes.set(item.id, { ...here, x: here.x + origin.x, y: here.y + origin.y });
    }
    const moved = ({ x, y }: Point): Point => ({ x: x + dx + origin.x, y: y + dy + origin.y });
    for (const edge of laid.flow.edges) {
      const { y, height } = boxes.get(edge.source) as Box;
      edges.push({ ...edge, bends: (laid.layout.bends.get(edge.id) ?? []).map(moved), bottom: y + height });
    }
    for (const [path, inner] of laid.inside) {
      const box = boxes.get(path) as Box;
      const top = box.height - inner.extent.height - MARGIN;
      place(inner, path, { x: box.x, y: box.y }, MARGIN - inner.extent.x, top - inner.extent.y);
    }
  };
  place(whole, null, { x: 0, y: 0 }, 0, 0);
  return { flow: whole.flow, items, edges, boxes };
}

/** Whether a node stands in the chart of a container: all that is between them is open. */
export function isCharted(path: string, container: string, opened: ReadonlySet<string>): boolean {
  for (let above = parentOf(path); above !== null; above = parentOf(above)) {
    if (above === container) return true;
    if (!opened.has(above)) return false;
  }
  return false;
}

/** Where something that was put to a place of the drawing stands in the chart of its own container: what its pin says. */
export function pinAt(chart: FlowChart, id: string, { x, y }: Point): [number, number] {
  const origin = chart.items.find((each) => each.item.id === id)?.origin ?? { x: 0, y: 0 };
  return [x - origin.x, y - origin.y];
}

/** The container in whose chart something stands. */
export function chartedIn(id: string, container: string): string {
  const mark = id.indexOf("#");
  if (mark === 0) return container;
  return mark > 0 ? id.slice(0, mark) : (parentOf(id) ?? "/");
}

function extentOf(boxes: Iterable<Box>): Box {
  const all = [...boxes];
  const x = Math.min(...all.map((box) => box.x));
  const y = Math.min(...all.map((box) => box.y));
  if (all.length === 0) return { x: 0, y: 0, width: 0, height: 0 };
  return { x, y, width: Math.max(...all.map((box) => box.x + box.width)) - x, height: Math.max(...all.map((box) => box.y + box.height)) - y };
}
