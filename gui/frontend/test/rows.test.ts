import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { counting, labelsOf, literalsText, parseLiterals, rulesOf, shifted, waitOf, withLabels } from "../src/model/rows";

describe("rules of a parallel", () => {
  it("look at a child with one label, with several, and no more", () => {
    const one = withLabels({ then: "done" }, "find", ["success"]);
    expect(one).toEqual({ when: { find: "success" }, then: "done" });
    const two = withLabels(one, "find", ["success", "failure.slipped"]);
    expect(labelsOf(two, "find")).toEqual(["success", "failure.slipped"]);
    expect(withLabels(two, "find", [])).toEqual({ then: "done" });
  });

  it("keep the order of the children that they look at", () => {
    const rule = { when: { a: "success", b: "failure" }, then: "done" } as const;
    expect(Object.keys(withLabels(rule, "a", ["failure"]).when ?? {})).toEqual(["a", "b"]);
  });

  it("count children, and say what is meant only where it isn't usual", () => {
    expect(counting({ then: "done" }, 2, "success")).toEqual({ at_least: 2, then: "done" });
    expect(counting({ then: "done" }, 2, "failure")).toEqual({ at_least: 2, ends: "failure", then: "done" });
    expect(counting({ at_least: 2, ends: "failure", then: "done" }, null, "failure")).toEqual({ then: "done" });
    expect(rulesOf(undefined)).toEqual([]);
  });
});

describe("rows", () => {
  it("move by one place, and not over the end", () => {
    expect(shifted(["a", "b", "c"], 2, -1)).toEqual(["a", "c", "b"]);
    expect(shifted(["a", "b"], 1, 1)).toEqual(["a", "b"]);
    expect(shifted(["a", "b"], 0, -1)).toEqual(["a", "b"]);
  });

  it("of cases read what they write", () => {
    const literal = fc.oneof(fc.integer(), fc.boolean(), fc.string(), fc.constant(null));
    fc.assert(
      fc.property(fc.oneof(literal, fc.array(literal, { minLength: 2 })), (said) => {
        expect(parseLiterals(literalsText(said))).toEqual({ value: said });
      }),
    );
    expect(parseLiterals("left, 2")).toEqual({ value: ["left", 2] });
    expect("fault" in parseLiterals("{")).toBe(true);
    expect("fault" in parseLiterals("")).toBe(true);
    expect("fault" in parseLiterals("[1]")).toBe(true);
  });

  it("say whom a parallel waits for", () => {
    expect([undefined, "all", "any", 2, ["a"]].map(waitOf)).toEqual(["", "all", "any", "count", "these"]);
  });
});
