import { describe, expect, it } from "vitest";

import { along, Motion, newtonsOf } from "../src/model/timeline";

const BOX = { kind: "box" as const, size: [1, 1, 1], at: [0, 0, 0, 1, 0, 0, 0], hand: "", fixed: false, body: "" };
const NOTHING = { q: {}, way: {}, plans: {}, touch: null, press: null, scene: null };
const WEDGE = { points: "AAAA", triangles: "AAAA" };

describe("the motion of a run", () => {
  const motion = new Motion();
  it("is nowhere before anything was measured", () => {
    expect(motion.at(1)).toBeNull();
  });
  it("carries on what hasn't changed, over the ends of pieces", () => {
    motion.add({ parts: { arm: ["a", "b"], hand: ["c"] }, bodies: { wedge: WEDGE }, samples: [{ ...NOTHING, t: 1, q: { arm: [0.1, 0.2], hand: [0.3] }, scene: { box: BOX }, touch: { hand: { tip: 2 } } }], next: 10 });
    motion.add({ parts: {}, bodies: {}, samples: [{ ...NOTHING, t: 2, q: { arm: [0.5, 0.6] }, way: { arm: [[0.5, 0.6], [1, 2]] } }, { ...NOTHING, t: 3, q: {}, scene: {}, touch: {} }], next: 20 });
    expect(motion.next).toBe(20);
    expect(motion.at(99)?.bodies["wedge"]).toBe(WEDGE);
    expect(Object.fromEntries(motion.at(2.5)?.joints ?? [])).toEqual({ a: 0.5, b: 0.6, c: 0.3 });
    expect(Object.keys(motion.at(2.5)?.scene ?? {})).toEqual(["box"]);
    expect(Object.keys(motion.at(99)?.scene ?? {})).toEqual([]);
    expect(motion.at(1.5)?.ways).toEqual([]);
    expect(motion.at(99)?.ways.map(({ arm, points }) => [arm, Object.fromEntries(points[1] ?? [])])).toEqual([["arm", { a: 1, b: 2 }]]);
    expect([2.5, 99].map((t) => [...(motion.at(t)?.touch ?? [])])).toEqual([[["tip", 2]], []]);
  });
  it("lets a way be over when its arm has arrived, or goes another one, and a plan go when it is begun", () => {
    const arms = new Motion();
    const [there, back] = [[[0], [1]], [[1], [0]]];
    arms.add({
      parts: { left: ["l"], right: ["r"] },
      bodies: {},
      samples: [
        { ...NOTHING, t: 1, plans: { left: [there, back] } },
        { ...NOTHING, t: 2, plans: { left: [back] }, way: { left: there, right: there } },
        { ...NOTHING, t: 3, plans: { left: [] }, way: { left: back } },
        { ...NOTHING, t: 4, way: { right: [] } },
      ],
      next: 10,
    });
    const told = (t: number) => [arms.at(t)?.ways.map(({ arm, over }) => `${arm}${over ? " over" : ""}`), arms.at(t)?.plans.map(({ points }) => points[0]?.get("l"))];
    expect(told(1)).toEqual([[], [0, 1]]);
    expect(told(2)).toEqual([["left", "right"], [1]]);
    expect(told(3)).toEqual([["left", "left over", "right"], []]);
    expect(told(4)).toEqual([["left", "left over", "right over"], []]);
  });
  it("tells how far along a way an arm is, however it stands beside it", () => {
    const way = [[0, 0], [1, 0], [1, 0], [1, 2]].map(([a = 0, b = 0]) => new Map([["a", a], ["b", b]]));
    const at = (a: number, b: number) => along(way, new Map([["a", a], ["b", b], ["other", 9]]));
    expect([at(-1, 0), at(0.25, -0.1), at(1, 0), at(1.1, 0.5), at(1, 9)]).toEqual([0, 0.25, 1, 2.25, 3]);
    expect(along(way, new Map())).toBe(0);
  });
  it("has the contacts of a time, and the hardest of all for the scale of their arrows", () => {
    const hands = new Motion();
    const point = (newtons: number): [string, string, number[], number[]] => ["tip", "mug", [0, 0, 1], [0, 0, newtons]];
    hands.add({ parts: {}, bodies: {}, samples: [{ ...NOTHING, t: 1, press: { one: [point(2)], other: [point(-7), point(3)] } }, { ...NOTHING, t: 2, q: {} }, { ...NOTHING, t: 3, press: {} }], next: 10 });
    expect([1, 2, 3].map((t) => hands.at(t)?.press.map(({ force }) => force[2]))).toEqual([[2, -7, 3], [2, -7, 3], []]);
    expect(hands.at(3)?.hardest).toBe(7);
    expect([0, 0.2, 1, 7, 12, 199].map(newtonsOf)).toEqual([0.05, 0.1, 0.5, 5, 5, 100]);
  });
  it("begins with what was measured first", () => {
    expect(motion.at(0)?.t).toBe(1);
    expect(motion.at(1)?.joints.get("b")).toBe(0.2);
  });
});
