import { describe, expect, it } from "vitest";
import { historyRows } from "../src/model/history";
import { findings, matching } from "../src/model/commands";
import { TaskIndex } from "../src/model/status";
import { parseValue, usesOf, valueText } from "../src/model/values";
import { node, task } from "./tasks";

describe("literals in fields", () => {
  it("are read by their type, and refused with what was needed", () => {
    expect(parseValue("3", "int")).toEqual({ value: 3 });
    expect(parseValue("3.5", "int")).toEqual({ fault: "A whole number is needed." });
    expect(parseValue("soon", "float")).toEqual({ fault: "A number is needed." });
    expect(parseValue(" 07 x", "str")).toEqual({ value: " 07 x" });
    expect(parseValue('["a", 1]', "list[str]")).toEqual({ value: ["a", 1] });
    expect(parseValue("home", "Any")).toEqual({ value: "home" });
    expect("fault" in parseValue("{", "json")).toBe(true);
  });

  it("come back as they went", () => {
    for (const [value, type] of [[3, "int"], [0.25, "float"], ["text", "str"], [[1, { a: null }], "Any"], [true, "bool"]] as const) {
      expect(parseValue(valueText(value, type), type)).toEqual({ value });
    }
    expect(valueText(undefined, "int")).toBe("");
  });
});

describe("search", () => {
  const found = findings(
    task([node("/", { kind: "sequence", children: ["look"] }), node("look", { label: "sensor/overhead", parameters: { state: "over the table" }, outputs: { points: "cloud" } })], {
      variables: [{ scope: "", name: "cloud", type: "PointCloud", doc: "what is seen", initial: null, whole: true, ports: [] }],
    }),
  );
  it("finds nodes by name, kind and value, and variables by type and documentation", () => {
    const labels = (text: string): string[] => matching(found, text).map((each) => each.label);
    expect(labels("table")).toEqual(["look"]);
    expect(labels("cloud")).toEqual(["cloud", "look"]);
    expect(labels("seen")).toEqual(["cloud"]);
    expect(labels("overhead leaf")).toEqual(["look"]);
    expect(labels("nothing like it")).toEqual([]);
  });
});

it("the lens finds writers, readers and expressions, in the scope that is meant", () => {
  const whole = task(
    [
      node("/", { kind: "sequence", children: ["a", "inner"] }),
      node("a", { outputs: { value: "v" }, fields: { precondition: "v > 2" } }),
      node("inner", { kind: "sequence", children: ["inner/b"] }),
      node("inner/b", { inputs: { value: "v" } }),
    ],
    {
      variables: [
        { scope: "", name: "v", type: "int", doc: "", initial: null, whole: true, ports: [] },
        { scope: "inner", name: "v", type: "int", doc: "", initial: null, whole: true, ports: [] },
      ],
    },
  );
  const index = new TaskIndex(whole);
  expect(usesOf(index, ":v")).toEqual([
    { path: "a", how: "writes" },
    { path: "a", how: "looks at" },
  ]);
  expect(usesOf(index, "inner:v")).toEqual([{ path: "inner/b", how: "reads" }]);
});

it("the history shows where it is, and branches that were left", () => {
  const moments = [
    { number: 0, parent: null, title: "opened" },
    { number: 1, parent: 0, title: "one" },
    { number: 2, parent: 0, title: "two" },
    { number: 3, parent: 2, title: "three" },
  ];
  const rows = historyRows({ at: 2, moments, can_undo: true, can_redo: true });
  expect(rows.map((row) => [row.number, row.branch, row.current])).toEqual([
    [3, 0, false],
    [2, 0, true],
    [1, 1, false],
    [0, 0, false],
  ]);
  expect(rows[2]?.starts).toBe(true);
});
