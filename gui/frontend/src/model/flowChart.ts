/** A flow chart with containers open in it: each is laid out by itself, and stands in its box with its ends on the border. */
import type { ElkNode } from "elkjs/lib/elk-api";
import type { NodeView, TaskView } from "../protocol/generated";
import { parentOf } from "./commands";
import { type Flow, type FlowEdge, type FlowItem, flowOf, isEnd } from "./flow";
import { graphOf, type Lay, type Level, levelOf, PLACEMENTS } from "./flowElk";
import { gridOf, inRows, rowsOf } from "./flowRows";
import { type Pins, withPins } from "./flowPins";
import type { Box, Point } from "./layout";

/** What a chart shows, before it has places. */
export interface Scene {
  readonly flow: Flow;
  /** Of a container that is open in another chart: its own box there. */
  readonly box: FlowItem | null;
  readonly inside: ReadonlyMap<string, Scene>;
}

export interface PlacedItem {
  readonly item: FlowItem;
  /** The box in which it stands; null in the chart itself. */
  readonly parent: string | null;
  /** Relative to that box. */
  readonly box: Box;
  /** Where the origin of its own chart is, relative to that box: pins are positions in that chart. */
  readonly origin: Point;
  /** Where its entry and its outcomes are, relative to its box; only of containers that are open. */
  readonly ports: ReadonlyMap<string, Point> | null;
}

export interface PlacedEdge extends FlowEdge {
  /** On the whole chart, from the outcome to the entry. */
  readonly points: readonly Point[];
  /** The middle of its words. */
  readonly words: Point | null;
}

export interface FlowChart {
  readonly flow: Flow;
  /** Boxes before what stands in them. */
  readonly items: readonly PlacedItem[];
  readonly edges: readonly PlacedEdge[];
  /** Where everything is on the whole chart; ends and starts of open containers are on their borders and aren't among them. */
  readonly boxes: ReadonlyMap<string, Box>;
}

/** Above so many nodes in one container a layered layout takes too long, or more stack than a browser has. */
const MOST = 300;

/** @param opened containers whose inside is shown in place. */
export function sceneOf(task: TaskView, byPath: ReadonlyMap<string, NodeView>, container: string, opened: ReadonlySet<string>, box: FlowItem | null = null): Scene {
  const flow = flowOf(task, byPath, container, box === null ? "" : container);
  const open = flow.items.filter((item) => item.node !== undefined && item.node.children.length > 0 && opened.has(item.id));
  return { flow, box, inside: new Map(open.map((item) => [item.id, sceneOf(task, byPath, item.id, opened, item)])) };
}

interface Laid {
  readonly level: Level;
  readonly origin: Point;
  readonly inside: ReadonlyMap<string, Laid>;
}

/**
 * The chart of a scene.
 * @param pins positions of pinned nodes, each in the chart of its own container.
 */
export async function chartOf(scene: Scene, pins: Pins, lay: Lay): Promise<FlowChart> {
  return placed(scene, await laidOut(scene, pins, lay, chartsIn(scene) > SEVERAL ? PLACEMENTS.slice(0, 1) : PLACEMENTS));
}

/** With more containers open, other ways to place nodes aren't tried: that would take several times as long. */
const SEVERAL = 30;
const chartsIn = (scene: Scene): number => [...scene.inside.values()].reduce((sum, inner) => sum + chartsIn(inner), 1);

/** Inner charts before those in which they stand: their sizes and the places of their ends have to be known. */
async function laidOut(scene: Scene, pins: Pins, lay: Lay, placements: typeof PLACEMENTS): Promise<Laid> {
  const inside = new Map<string, Laid>();
  for (const [path, inner] of scene.inside) inside.set(path, await laidOut(inner, pins, lay, placements));
  const levels = new Map([...inside].map(([path, laid]) => [path, laid.level]));
  const free = scene.flow.items.length > MOST ? gridOf(scene.flow, levels, scene.box) : await readable(scene, levels, lay, placements);
  return { ...withPins(free, scene.flow, pins, levels, scene.box !== null), inside };
}

/** In one line, or in rows where it can be read better so. */
async function readable(scene: Scene, levels: ReadonlyMap<string, Level>, lay: Lay, placements: typeof PLACEMENTS): Promise<Level> {
  const rows = rowsOf(scene.flow, levels, scene.box);
  if (rows.length === 0) return straightest(scene, levels, lay, placements);
  return inRows(scene.flow, await Promise.all(rows.map((row) => straightest(scene, levels, lay, placements, row))), scene.box);
}

/** Up to so many nodes other ways to place them are tried, where success isn't a straight line. */
const FEW = 60;

/** The layout in which most edges of success are straight; the first of those. */
async function straightest(scene: Scene, levels: ReadonlyMap<string, Level>, lay: Lay, placements: typeof PLACEMENTS, row?: ReadonlySet<string>): Promise<Level> {
  const bent = (level: Level): number => scene.flow.edges.filter((edge) => edge.meaning === "success" && !isBack(level, edge) && (level.lines.get(edge.id)?.points.length ?? 2) > 2).length;
  let best: Level | null = null;
  for (const placement of placements) {
    const level = levelOf(await lay(graphOf(scene.flow, levels, scene.box, placement, row)));
    if (best === null || bent(level) < bent(best)) best = level;
    if (bent(best) === 0 || scene.flow.items.length > FEW) break;
  }
  return best as Level;
}

/** Whether an edge leads to what stands left of where it begins, or ends the container. */
function isBack(level: Level, edge: FlowEdge): boolean {
  const [from, to] = [level.boxes.get(edge.source), level.boxes.get(edge.target)];
  return from === undefined || to === undefined || isEnd(edge.target) || to.x < from.x + from.width;
}

function placed(scene: Scene, laid: Laid): FlowChart {
  const items: PlacedItem[] = [];
  const edges: PlacedEdge[] = [];
  const boxes = new Map<string, Box>();
  const place = ({ flow, inside }: Scene, { level, origin, inside: inner }: Laid, parent: string | null, at: Point): void => {
    const moved = ({ x, y }: Point): Point => ({ x: x + at.x, y: y + at.y });
    for (const item of flow.items) {
      const found = level.boxes.get(item.id);
      if (found === undefined) continue;
      const { x, y, width, height } = found;
      items.push({ item: { ...item, width, height }, parent, box: { x, y, width, height }, origin, ports: inner.get(item.id)?.level.ports ?? null });
      boxes.set(item.id, { ...moved(found), width, height });
    }
    for (const edge of flow.edges) {
      const line = level.lines.get(edge.id);
      if (line) edges.push({ ...edge, points: line.points.map(moved), words: line.label && moved(line.label) });
    }
    for (const [path, each] of inside) place(each, inner.get(path) as Laid, path, boxes.get(path) as Box);
  };
  place(scene, laid, null, { x: 0, y: 0 });
  return { flow: scene.flow, items, edges, boxes };
}

/** Layouts that are kept: a change in one container lays out that one and those around it. */
const KEPT = 100;

/** A layout that remembers its answers: nothing that leaves sizes, order and edges as they were is laid out again. */
export function remembering(lay: Lay): Lay {
  const known = new Map<string, Promise<ElkNode>>();
  return (graph) => {
    const key = JSON.stringify(graph);
    const answer = known.get(key) ?? lay(graph);
    known.delete(key);
    known.set(key, answer);
    answer.catch(() => known.delete(key));
    for (const old of known.keys()) if (known.size > KEPT) known.delete(old);
    return answer;
  };
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
