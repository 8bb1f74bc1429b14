/** Charts as they are drawn, laid out here by what the page has in a worker. */
import { readFileSync } from "node:fs";

import ELK from "elkjs/lib/elk.bundled.js";

import { type FlowChart, chartOf, remembering, type Scene, sceneOf } from "../src/model/flowChart";
import type { Lay } from "../src/model/flowElk";
import { labelWidth, LABEL_HEIGHT } from "../src/model/flowElk";
import type { Pins } from "../src/model/flowPins";
import { TaskIndex } from "../src/model/status";
import type { NodeView, TaskView } from "../src/protocol/generated";
import { measureFlow } from "../scripts/measure_flow.mjs";
import { node, task } from "./tasks";

const elk = new ELK();
export const lay: Lay = remembering((graph) => elk.layout(structuredClone(graph)));

interface Kept {
  readonly name: string;
  readonly outcomes: TaskView["outcomes"];
  readonly nodes: Partial<NodeView>[];
}
const KEPT = JSON.parse(readFileSync(new URL("flows.json", import.meta.url), "utf8")) as Record<string, Kept>;

/** Charts: a task, one of its containers, and those that are open in it. */
export const CHARTS: readonly [string, string, readonly string[]][] = [
  ["reactive_pick", "/", []],
  ["reactive_pick", "next_object/attempt", []],
  ["reactive_pick", "next_object/attempt/pick", []],
  ["reactive_pick", "/", ["next_object", "next_object/attempt", "next_object/attempt/pick"]],
  ["fill_shelf", "/", ["slots"]],
  ["two_states", "/", []],
  ["nested", "/", ["FETCH"]],
  ["together", "/", ["CON"]],
  ["forty", "/", []],
  ["cross_door", "/", ["opened", "opened/open"]],
  ["chain_8", "/", []],
  ["chain_12", "/", []],
  ["chain_20", "/", []],
];

export function keptTask(name: string): TaskView {
  const kept = KEPT[name] as Kept;
  return task(kept.nodes.map((each) => node(each.path as string, each)), { name, outcomes: kept.outcomes });
}

export const sceneIn = (of: TaskView, container: string, opened: readonly string[]): Scene => sceneOf(of, new TaskIndex(of).byPath, container, new Set(opened));
export const drawn = (of: TaskView, container = "/", opened: readonly string[] = [], pins: Pins = {}): Promise<FlowChart> => chartOf(sceneIn(of, container, opened), pins, lay);

/** How large the whole of a chart is shown in a page of 1280 x 720 with all its panes: the chart has 690 x 524 of it. */
export const wholeAt = ({ width, height }: { width: number; height: number }): number => Math.min(1.1, (0.95 * 690) / width, (0.95 * 524) / height);

export function measured(chart: FlowChart): ReturnType<typeof measureFlow> {
  const parents = new Map(chart.items.map(({ item, parent }) => [item.id, parent]));
  const boxes = [...chart.boxes].map(([id, box]) => ({ id, parent: parents.get(id) ?? null, ...box }));
  // Ends and starts of open containers are on their borders.
  const held = (id: string): string => (chart.boxes.has(id) ? id : id.slice(0, id.indexOf("#")));
  const edges = chart.edges.map(({ id, source, target, meaning, points, label, words }) => {
    const width = labelWidth(label) - 10;
    return { id, source: held(source), target: held(target), meaning, points: [...points], label: words && { x: words.x - width / 2, y: words.y - LABEL_HEIGHT / 2, width, height: LABEL_HEIGHT } };
  });
  return measureFlow({ boxes, edges });
}
