import { describe, expect, it } from "vitest";

import { Motion } from "../src/model/timeline";

const BOX = { kind: "box" as const, size: [1, 1, 1], at: [0, 0, 0, 1, 0, 0, 0], hand: "", fixed: false, body: "" };
const NOTHING = { q: {}, way: {}, touch: null, scene: null };
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
  it("begins with what was measured first", () => {
    expect(motion.at(0)?.t).toBe(1);
    expect(motion.at(1)?.joints.get("b")).toBe(0.2);
  });
});
