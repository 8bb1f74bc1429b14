import { readFileSync } from "node:fs";

import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { endId, flowOf, START } from "../src/model/flow";
import { chartedIn, type FlowChart, isCharted, pinAt } from "../src/model/flowChart";
import type { Box } from "../src/model/layout";
import { readingOrder } from "../src/model/flow";
import { TaskIndex } from "../src/model/status";
import type { NodeView } from "../src/protocol/generated";
import { CHARTS, drawn, keptTask, lay, measured, sceneIn, wholeAt } from "./charts";
import { node, task } from "./tasks";

function chart(kind: string, children: NodeView[], part: Partial<NodeView> = {}) {
  const root = node("/", { kind, children: children.map((child) => child.path), ...part });
  const whole = task([root, ...children]);
  return flowOf(whole, new TaskIndex(whole).byPath, "/");
}
const lines = (flow: ReturnType<typeof chart>): string[] => flow.edges.map((edge) => `${edge.source}.${edge.outcome} ${edge.derived ? "~" : "-"} ${edge.target}`);

describe("a container as a flow chart", () => {
  it("shows the edges of a state machine as they stand in the file", () => {
    const a = node("a", { initial: true, on: [{ outcome: "success", target: "b", ends: false }, { outcome: "failure.no_plan", target: "gone", ends: true }] });
    const flow = chart("state_machine", [a, node("b")], { outcomes: { gone: "failure", never: "success" } });
    expect(lines(flow)).toEqual([`${START}. ~ a`, "a.success - b", `a.failure.no_plan - ${endId("gone")}`]);
    expect(flow.items.filter((item) => item.kind === "end").map((item) => item.outcome)).toEqual(["gone", "never"]);
    expect(flow.items.find((item) => item.id === "a")?.ports.map((port) => [port.outcome, port.led])).toEqual([
      ["success", true],
      ["failure", false],
      ["failure.no_plan", true],
    ]);
  });

  it("shows edges that follow from the kind, as the server says; other ends end the container with their meaning", () => {
    const leads = (meaning: string): NodeView[] => [node("a", { initial: true, derived: [{ outcome: meaning, target: "b", ends: false }] }), node("b")];
    expect(lines(chart("sequence", leads("success")))).toEqual([`${START}. ~ a`, "a.success ~ b", `a.failure ~ ${endId("failure")}`, `b.success ~ ${endId("success")}`, `b.failure ~ ${endId("failure")}`]);
    expect(lines(chart("fallback", leads("failure")))).toContain("a.failure ~ b");
    expect(lines(chart("fallback", leads("failure")))).toContain(`a.success ~ ${endId("success")}`);
  });

  it("shows exits as stored, a retry as a loop, an inversion crossed, and nothing where edges can't say it", () => {
    const a = node("a", { on: [{ outcome: "failure", target: "lost", ends: true }] });
    expect(lines(chart("sequence", [a], { outcomes: { success: "success", failure: "failure", lost: "failure" } }))).toContain(`a.failure - ${endId("lost")}`);
    expect(lines(chart("retry", [node("a", { initial: true, derived: [{ outcome: "failure", target: "a", ends: false }] })], { label: "at most 3 attempts" }))).toEqual([`a.success ~ ${endId("success")}`, "a.failure ~ a"]);
    expect(lines(chart("invert", [node("a", { derived: [{ outcome: "success", target: "failure", ends: true }] })]))).toContain(`a.success ~ ${endId("failure")}`);
    const parallel = chart("parallel", [node("a"), node("b")]);
    expect(lines(parallel)).toEqual([]);
    expect(parallel.items.flatMap((item) => item.ports.filter((port) => !port.led))).toEqual([]);
    expect(chart("sequence", [node("a")], { label: "asks again on every tick" }).strip).toMatch(/every tick/);
  });
});

const randomTask = fc.integer({ min: 1, max: 14 }).chain((count) =>
  fc.array(fc.tuple(fc.nat(count - 1), fc.nat(count - 1)), { maxLength: 30 }).map((pairs) => {
    const children = Array.from({ length: count }, (_, i) =>
      node(`n${i}`, { initial: i === 0, on: pairs.filter(([from]) => from === i).slice(0, 2).map(([, to], k) => ({ outcome: k === 0 ? "success" : "failure", target: `n${to}`, ends: false })) }),
    );
    return task([node("/", { kind: "state_machine", children: children.map((child) => child.path), outcomes: { success: "success" } }), ...children]);
  }),
);
/** States one after another, each of which may fail. */
function chainOf(names: readonly string[], fails: readonly string[] = ["failed"]) {
  const children = names.map((name, i) =>
    node(name, {
      initial: i === 0,
      label: "tutorial/step",
      outcomes: { success: "success", failure: "failure" },
      on: [
        { outcome: "success", target: names[i + 1] ?? "done", ends: i + 1 === names.length },
        { outcome: "failure", target: fails[i % fails.length] as string, ends: true },
      ],
    }),
  );
  const ends = Object.fromEntries(fails.map((end) => [end, "failure"]));
  return task([node("/", { kind: "state_machine", children: names.map(String), outcomes: { done: "success", ...ends } }), ...children]);
}
const randomChain = fc
  .tuple(fc.uniqueArray(fc.stringMatching(/^[a-z]{2,24}$/), { minLength: 2, maxLength: 20 }), fc.uniqueArray(fc.constantFrom("lost", "blocked", "gave_up"), { minLength: 1, maxLength: 3 }))
  .map(([names, fails]) => chainOf(names.map((name) => `s_${name}`), fails));
const CLEAR = { overlaps: 0, behind: 0, covered: 0 };

describe("the layout", () => {
  const told = readFileSync(new URL("../../../docs/benchmarks.md", import.meta.url), "utf8").split("### Flow charts")[1] ?? "";
  const rows = [...told.matchAll(/^\| .*? \| (\d+) \| (\d+) \| (\d+) \| (\d+) of (\d+) \| ([\d.]+) \|/gm)].map((row) => row.slice(1).map(Number));
  it.each(CHARTS.map(([name, container, opened], i) => [name, container, opened, rows[i]] as const))("draws %s at %s clear: nothing on anything, no edge behind a box, no covered words; and as the docs say", async (name, container, opened, row) => {
    const { boxes, edges, crossings, straight, ahead, ...rest } = measured(await drawn(keptTask(name), container, opened));
    expect(rest).toMatchObject(CLEAR);
    expect([boxes, edges, crossings, straight, ahead, Number(wholeAt(rest).toFixed(2))]).toEqual(row);
  });

  it("shows chains as a whole at a size at which they can be read in a page of 1280 x 720: in rows, success straight in each", async () => {
    await fc.assert(
      fc.asyncProperty(randomChain, async (of) => {
        const count = of.nodes.length - 1;
        const { overlaps, behind, covered, straight, ahead, crossings, ...size } = measured(await drawn(of));
        expect({ overlaps, behind, covered }).toEqual(CLEAR);
        expect(straight).toBe(ahead);
        // Where all failures end alike they cross the way from each row to the next once, and that to success.
        const ends = new Set(of.nodes.flatMap((each) => each.on.map((edge) => edge.target))).size - count;
        if (ends === 1) expect(crossings).toBeLessThanOrEqual(count - ahead);
        // 9 px of names that are 13 px large; of longer chains names alone can be read: they are 17 px then.
        expect(wholeAt(size) * (count <= 12 ? 13 : 17)).toBeGreaterThan(9);
      }),
      { numRuns: 25 },
    );
  });

  it("moves little of a chart in rows when a state is put in, and nothing above it", async () => {
    const names = Array.from({ length: 12 }, (_, i) => `state_${i}`);
    const [before, after] = [await drawn(chainOf(names)), await drawn(chainOf(names.toSpliced(10, 0, "put_in")))];
    const moved = names.filter((id) => JSON.stringify(before.boxes.get(id)) !== JSON.stringify(after.boxes.get(id)));
    expect(moved.length).toBeLessThanOrEqual(6);
  });

  it("is the same every time, and clear, whatever leads where", async () => {
    await fc.assert(
      fc.asyncProperty(randomTask, async (of) => {
        const chart = await drawn(of);
        expect(measured(chart)).toMatchObject(CLEAR);
        expect(await drawn(structuredClone(of))).toEqual(chart);
      }),
      { numRuns: 40 },
    );
  });

  it("never moves what was pinned, lets nothing lie on it, and leads edges round it", async () => {
    await fc.assert(
      fc.asyncProperty(randomTask, fc.array(fc.tuple(fc.integer({ min: -900, max: 900 }), fc.integer({ min: -900, max: 900 })), { maxLength: 1 }), async (of, spots) => {
        const pins = Object.fromEntries(spots.map((spot, i) => [`n${i}`, spot]));
        const chart = await drawn(of, "/", [], pins);
        for (const [id, [x, y]] of Object.entries(pins)) expect(chart.boxes.get(id)).toMatchObject({ x, y });
        expect(measured(chart)).toMatchObject({ overlaps: 0, behind: 0 });
      }),
      { numRuns: 40 },
    );
  });

  it("keeps those that a person has put on each other where they are, and still draws every edge", async () => {
    const chart = await drawn(keptTask("nested"), "/", [], { LOCALIZE: [40, 40], FETCH: [60, 50], DELIVER: [50, 60] });
    expect(chart.boxes.get("FETCH")).toMatchObject({ x: 60, y: 50 });
    for (const edge of chart.edges) expect(edge.points.length).toBeGreaterThanOrEqual(2);
  });

  it("asks for nothing when only what runs changes, and moves little when an edge is led elsewhere", async () => {
    const of = keptTask("forty");
    const [graphs, counting] = [[] as string[], (graph: Parameters<typeof lay>[0]) => (graphs.push(JSON.stringify(graph)), lay(graph))];
    const { chartOf } = await import("../src/model/flowChart");
    await chartOf(sceneIn(of, "/", []), {}, counting);
    const asked = graphs.splice(0);
    const touched = { ...of, nodes: of.nodes.map((each) => ({ ...each, doc: "read again", parameters: {} })) };
    await chartOf(sceneIn(touched, "/", []), {}, counting);
    expect(graphs).toEqual(asked);
    const led = { ...of, nodes: of.nodes.map((each) => (each.name === "s0_2" ? { ...each, on: each.on.map((edge) => (edge.outcome === "failure.no_contact" ? { ...edge, target: "s0_0" } : edge)) } : each)) };
    const [before, after] = [await drawn(of), await drawn(led)];
    const moved = [...before.boxes].map(([id, box]) => Math.hypot(box.x - (after.boxes.get(id) as Box).x, box.y - (after.boxes.get(id) as Box).y)).sort((a, b) => a - b);
    expect(moved[Math.floor(moved.length / 2)]).toBeLessThan(60);
  });

  it("draws a container of more nodes than a layered layout takes, in rows, with no edge behind a box", async () => {
    const children = Array.from({ length: 400 }, (_, i) => node(`n${i}`, { initial: i === 0, derived: i < 399 ? [{ outcome: "success", target: `n${i + 1}`, ends: false }] : [] }));
    const chart = await drawn(task([node("/", { kind: "sequence", children: children.map((child) => child.path) }), ...children]));
    expect(chart.boxes.size).toBe(403);
    expect(measured({ ...chart, edges: chart.edges.slice(0, 60) })).toMatchObject({ overlaps: 0, behind: 0 });
  });
});

describe("the reading order", () => {
  it("follows success, takes what closes a loop for no order, and leaves nothing out", () => {
    const edge = (source: string, target: string, meaning: string) => ({ id: `${source}-${target}`, source, target, outcome: meaning, derived: false, meaning, label: "" });
    const edges = [edge("a", "x", "failure"), edge("a", "b", "success"), edge("b", "c", "success"), edge("c", "a", "failure"), edge("x", "c", "success")];
    expect(readingOrder(["x", "c", "b", "a", "alone"], edges, "a")).toEqual(["a", "b", "x", "c", "alone"]);
  });
});

describe("a chart with containers open in it", () => {
  const lead = (outcome: string, target: string): Partial<NodeView> => ({ derived: [{ outcome, target, ends: false }] });
  const inner = ["x", "y"].map((name) => node(`g/${name}`, { parent: "g", ...lead("failure", name) }));
  const group = node("g", { kind: "retry", fields: { times: 2 }, children: inner.map((each) => each.path), ...lead("success", "b") });
  const root = node("/", { kind: "sequence", children: ["a", "g", "b"] });
  const whole = task([root, node("a", { initial: true, ...lead("success", "g") }), group, ...inner, node("b")]);
  const chart = (opened: string[], pins = {}): Promise<FlowChart> => drawn(whole, "/", opened, pins);

  it("holds the inside of an open one in its box, with its ends on the border, and nothing of a closed one", async () => {
    expect((await chart([])).items.map((each) => each.item.id)).not.toContain("g/x");
    const open = await chart(["g"]);
    const box = open.boxes.get("g") as Box;
    for (const { item, parent } of open.items.filter((each) => each.parent !== null)) {
      const { x, y, width, height } = open.boxes.get(item.id) as Box;
      expect(parent).toBe("g");
      expect(x).toBeGreaterThan(box.x);
      expect(y).toBeGreaterThan(box.y + 46);
      expect(x + width).toBeLessThan(box.x + box.width);
      expect(y + height).toBeLessThan(box.y + box.height);
    }
    const ids = open.items.map((each) => each.item.id);
    expect(ids.findIndex((id) => id === "g")).toBeLessThan(ids.findIndex((id) => id === "g/x"));
    const [out] = open.edges.filter((edge) => edge.target === endId("success", "g"));
    expect(out?.points.at(-1)?.x).toBe(box.x + box.width);
    expect(open.edges.find((edge) => edge.id === "g.success")?.points[0]).toEqual(out?.points.at(-1));
  });

  it("leaves what is dragged inside an open one where it was put", async () => {
    const open = await chart(["g"]);
    for (const id of ["g/x", "g/y"]) {
      const { box } = open.items.find((each) => each.item.id === id) as (typeof open.items)[number];
      const pin = pinAt(open, id, { x: box.x + 40, y: box.y + 70 });
      const again = await chart(["g"], { [id]: pin });
      expect(again.items.find((each) => each.item.id === id)?.box).toMatchObject({ x: box.x + 40, y: box.y + 70 });
      expect(measured(again)).toMatchObject({ overlaps: 0, behind: 0 });
      expect((await drawn(whole, "g", [], { [id]: pin })).boxes.get(id)).toMatchObject({ x: pin[0], y: pin[1] });
    }
    const outer = open.boxes.get("a") as Box;
    expect(pinAt(open, "a", outer)).toEqual([outer.x, outer.y]);
  });

  it("keeps ids apart, and knows in whose chart something stands", async () => {
    const ids = (await chart(["g"])).items.map((each) => each.item.id);
    expect(new Set(ids).size).toBe(ids.length);
    expect(["g/x", endId("success", "g"), endId("failure"), "a"].map((id) => chartedIn(id, "/"))).toEqual(["g", "g", "/", "/"]);
    expect(isCharted("g/x", "/", new Set())).toBe(false);
    expect(isCharted("g/x", "/", new Set(["g"]))).toBe(true);
    expect(isCharted("g/x", "g", new Set())).toBe(true);
  });

  it("leads a loop round its node", async () => {
    const open = await chart(["g"]);
    const loops = open.edges.filter((edge) => edge.source === edge.target);
    expect(loops.map((edge) => edge.source)).toEqual(["g/x", "g/y"]);
    for (const { source, points } of loops) {
      const { x, width } = open.boxes.get(source) as Box;
      expect(Math.min(...points.map((point) => point.x))).toBeLessThan(x);
      expect(Math.max(...points.map((point) => point.x))).toBeGreaterThan(x + width);
    }
  });
});
