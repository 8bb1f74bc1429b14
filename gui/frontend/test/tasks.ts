/** Small tasks and random ones for the tests of the model. */
import fc from "fast-check";

import { setKinds } from "../src/model/kinds";
import type { KindView, NodeView, RunEvent, SettingView, TaskView, Transition } from "../src/protocol/generated";

export function node(path: string, part: Partial<NodeView> = {}): NodeView {
  const parent = path === "/" ? null : path.includes("/") ? path.slice(0, path.lastIndexOf("/")) : "/";
  return {
    path,
    parent,
    name: path.split("/").at(-1) || "/",
    kind: "leaf",
    label: "flow/wait",
    doc: "",
    children: [],
    outcomes: { success: "success", failure: "failure" },
    initial: false,
    on: [],
    derived: [],
    inputs: {},
    outputs: {},
    parameters: {},
    fields: {},
    ...part,
  };
}

export function task(nodes: NodeView[], part: Partial<TaskView> = {}): TaskView {
  return { path: "tasks/t.yaml", name: "t", doc: "", outcomes: {}, nodes, variables: [], problems: [], ...part };
}

function kind(name: string, part: Partial<KindView> = {}): KindView {
  const same = { title: name.replace("_", " "), icon: "M0 0", doc: "", needs_child: false, edges: false, concurrent: false, declares: true, fields: [], blank: {} };
  return { kind: name, holds: "many", ...same, ...part };
}

const initial: SettingView = { key: "initial", type: "child", doc: "", required: true, default: null, choices: [] };
setKinds([
  kind("sequence"),
  kind("fallback"),
  kind("parallel", { concurrent: true }),
  kind("state_machine", { edges: true, needs_child: true, fields: [initial], blank: { initial: "", outcomes: { success: "success" } } }),
  kind("switch", { needs_child: true, fields: [{ ...initial, key: "cases", type: "cases" }], blank: { on_value: "0" } }),
  ...["retry", "invert"].map((name) => kind(name, { holds: "one", needs_child: true })),
]);

/** A sequence of a leaf, and a retry around a sequence of two leaves. */
export const SMALL = task(
  [
    node("/", { kind: "sequence", children: ["a", "again"] }),
    node("a", { outcomes: { one: "success", none: "failure" } }),
    node("again", { kind: "retry", children: ["again/both"] }),
    node("again/both", { kind: "sequence", children: ["again/both/x", "again/both/y"] }),
    node("again/both/x"),
    node("again/both/y"),
  ],
  {
    variables: [
      { scope: "", name: "v", type: "int", doc: "", initial: "0", whole: true, ports: [] },
      { scope: "again", name: "v", type: "int", doc: "", initial: null, whole: true, ports: [] },
    ],
  },
);

let clock = 0;

export function event(seq: number, path: string, kind: string, part: Partial<RunEvent> = {}): RunEvent {
  clock = seq === 0 ? 0 : clock + 0.5;
  return { seq, t: clock, path, event: kind, outcome: null, code: null, data: {}, ...part };
}

const edges: Transition[] = [
  { outcome: "success", target: "b", ends: false },
  { outcome: "failure", target: "c", ends: true },
];

/** Random trees of up to 200 nodes, parents first. */
export const randomTree: fc.Arbitrary<NodeView[]> = fc
  .array(fc.tuple(fc.nat(), fc.integer({ min: 0, max: 2 })), { maxLength: 200 })
  .map((picks) => {
    const made: { path: string; children: string[]; edges: number }[] = [{ path: "/", children: [], edges: 0 }];
    picks.forEach(([pick, count], i) => {
      const parent = made[pick % made.length] as (typeof made)[number];
      const path = parent.path === "/" ? `n${i}` : `${parent.path}/n${i}`;
      parent.children.push(path);
      made.push({ path, children: [], edges: count });
    });
    return made.map((m) =>
      node(m.path, { children: m.children, kind: m.children.length ? "sequence" : "leaf", on: edges.slice(0, m.edges) }),
    );
  });
