import { expect, test } from "vitest";

import { settingsOf } from "../src/model/settings";
import { GROUPS, groupOf, KINDS } from "../src/model/words";
import { GROUP_SHAPES, KIND_SHAPES } from "../src/view/icons";
import { node } from "./tasks";

test("every kind has a word and a drawing of its own, and so has every group of leaves", () => {
  expect(Object.keys(KIND_SHAPES).sort()).toEqual(Object.keys(KINDS).sort());
  const lists = ["containers", "tasks"];
  expect(Object.keys(GROUP_SHAPES).sort()).toEqual(Object.keys(GROUPS).filter((name) => !lists.includes(name)).sort());
  const shapes = [...Object.values(KIND_SHAPES), ...Object.values(GROUP_SHAPES)].map((shape) => JSON.stringify(shape.props));
  expect(new Set(shapes).size).toBe(shapes.length);
});

test("a node's group is what stands before the first slash", () => {
  expect(groupOf("arm/move_to")).toBe("arm");
  expect(groupOf("own")).toBe("own");
});

test("what a node is set to is said in the order of the file, without its documentation", () => {
  const leaf = node("a", { parameters: { state: "home", speed: 0.5 }, fields: { doc: "go", precondition: "n > 1" }, inputs: { pose: "target" }, outputs: { reached: "end" } });
  expect(settingsOf(leaf).map(({ name, text }) => `${name} ${text}`)).toEqual(["state home", "speed 0.5", "precondition n > 1", "pose ← target", "reached → end"]);
  expect(settingsOf(node("b"))).toEqual([]);
});
