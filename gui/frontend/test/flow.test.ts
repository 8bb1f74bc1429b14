import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { endId, flowOf, START } from "../src/model/flow";
import { chartedIn, chartOf, isCharted, pinAt } from "../src/model/flowChart";
import { type Box, layoutFlow } from "../src/model/flowLayout";
import { TaskIndex } from "../src/model/status";
import type { NodeView } from "../src/protocol/generated";
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

const randomChart = fc.integer({ min: 1, max: 14 }).chain((count) =>
  fc.array(fc.tuple(fc.nat(count - 1), fc.nat(count - 1)), { maxLength: 30 }).map((pairs) => {
    const children = Array.from({ length: count }, (_, i) =>
      node(`n${i}`, { initial: i === 0, on: pairs.filter(([from]) => from === i).slice(0, 2).map(([, to], k) => ({ outcome: k === 0 ? "success" : "failure", target: `n${to}`, ends: false })) }),
    );
    return chart("state_machine", children, { outcomes: { success: "success" } });
  }),
);

describe("the layout", () => {
  it("is the same every time, and nothing lies on anything else", () => {
    fc.assert(
      fc.property(randomChart, (flow) => {
        const boxes = [...layoutFlow(flow).boxes.values()];
        expect(boxes).toEqual([...layoutFlow(flow).boxes.values()]);
        for (const [i, one] of boxes.entries()) {
          for (const other of boxes.slice(i + 1)) {
            const apart = one.x + one.width <= other.x || other.x + other.width <= one.x || one.y + one.height <= other.y || other.y + other.height <= one.y;
            expect(apart).toBe(true);
          }
        }
      }),
      { numRuns: 60 },
    );
  });

  it("never moves what was pinned, and lets nothing lie on it", () => {
    fc.assert(
      fc.property(randomChart, fc.array(fc.tuple(fc.integer({ min: -900, max: 900 }), fc.integer({ min: -900, max: 900 })), { maxLength: 3 }), (flow, spots) => {
        const pins = Object.fromEntries(spots.map((spot, i) => [`n${i}`, spot]));
        const { boxes } = layoutFlow(flow, pins);
        const pinned = flow.items.filter((item) => pins[item.id]).map((item) => item.id);
        for (const id of pinned) expect([boxes.get(id)?.x, boxes.get(id)?.y]).toEqual(pins[id]);
        for (const id of pinned) {
          const one = boxes.get(id)!;
          for (const [other, box] of boxes) {
            if (pinned.includes(other)) continue;
            expect(one.x + one.width <= box.x || box.x + box.width <= one.x || one.y + one.height <= box.y || box.y + box.height <= one.y).toBe(true);
          }
        }
      }),
      { numRuns: 60 },
    );
  });
});

describe("a chart with containers open in it", () => {
  const lead = (outcome: string, target: string): Partial<NodeView> => ({ derived: [{ outcome, target, ends: false }] });
  const inner = ["x", "y"].map((name) => node(`g/${name}`, { parent: "g", ...lead("failure", name) }));
  const group = node("g", { kind: "retry", fields: { times: 2 }, children: inner.map((each) => each.path), ...lead("success", "b") });
  const root = node("/", { kind: "sequence", children: ["a", "g", "b"] });
  const whole = task([root, node("a", { initial: true, ...lead("success", "g") }), group, ...inner, node("b")]);
  const { byPath } = new TaskIndex(whole);
  const drawn = (opened: string[]) => chartOf(whole, byPath, "/", new Set(opened), {});

  it("holds the inside of an open one in its box, and nothing of a closed one", () => {
    expect(drawn([]).items.map((each) => each.item.id)).not.toContain("g/x");
    const chart = drawn(["g"]);
    const box = chart.boxes.get("g") as Box;
    for (const { item, parent } of chart.items.filter((each) => each.parent !== null)) {
      const { x, y, width, height } = chart.boxes.get(item.id) as Box;
      expect(parent).toBe("g");
      expect(x).toBeGreaterThan(box.x);
      expect(y).toBeGreaterThan(box.y + 46);
      expect(x + width).toBeLessThan(box.x + box.width);
      expect(y + height).toBeLessThan(box.y + box.height);
    }
    expect(chart.items.map((each) => each.item.id)).toContain(endId("success", "g"));
    expect(chart.items.findIndex((each) => each.item.id === "g")).toBeLessThan(chart.items.findIndex((each) => each.item.id === "g/x"));
  });

  it("pins what is dragged inside an open one where the chart of its own container has it", () => {
    const open = drawn(["g"]);
    const own = chartOf(whole, byPath, "g", new Set(), {});
    for (const id of ["g/x", "g/y"]) {
      const { box } = open.items.find((each) => each.item.id === id) as (typeof open.items)[number];
      const alone = own.boxes.get(id) as Box;
      expect(pinAt(open, id, box)).toEqual([alone.x, alone.y]);
      expect(pinAt(open, id, { x: box.x + 40, y: box.y - 7 })).toEqual([alone.x + 40, alone.y - 7]);
    }
    const outer = open.boxes.get("a") as Box;
    expect(pinAt(open, "a", outer)).toEqual([outer.x, outer.y]);
  });

  it("keeps ids apart, and every edge between things that are there", () => {
    const chart = drawn(["g"]);
    const ids = chart.items.map((each) => each.item.id);
    expect(new Set(ids).size).toBe(ids.length);
    for (const edge of chart.edges) expect(ids).toEqual(expect.arrayContaining([edge.source, edge.target]));
    expect(chart.edges.filter((edge) => edge.target === endId("success", "g")).length).toBe(2);
  });

  it("knows in whose chart something stands", () => {
    expect(["g/x", endId("success", "g"), endId("failure"), "a"].map((id) => chartedIn(id, "/"))).toEqual(["g", "g", "/", "/"]);
    expect(isCharted("g/x", "/", new Set())).toBe(false);
    expect(isCharted("g/x", "/", new Set(["g"]))).toBe(true);
    expect(isCharted("g/x", "g", new Set())).toBe(true);
  });

  it("leads a loop round below its node", () => {
    const loops = drawn(["g"]).edges.filter((edge) => edge.source === edge.target);
    expect(loops.map((edge) => edge.source)).toEqual(["g/x", "g/y"]);
    for (const { source, bottom } of loops) {
      const { y, height } = drawn(["g"]).boxes.get(source) as Box;
      expect(bottom).toBe(y + height);
    }
  });
});
