import { expect, test } from "vitest";

import { initials, pagesAt, taken, toTell } from "../src/model/others";

const at = (...nodes: string[]) => ({ task: "tasks/t.yaml", nodes });

test("what changed is taken over, and who has nothing selected any more goes", () => {
  const before = { ann: at("a"), bob: at("b") };
  expect(taken(before, { ann: null, eve: at("c") })).toEqual({ bob: at("b"), eve: at("c") });
  expect(before).toEqual({ ann: at("a"), bob: at("b") });
});

test("a selection is drawn at its node, and at a container that hides it", () => {
  const selections = { ann: at("pick/grasp"), bob: at("pick"), eve: { task: "tasks/other.yaml", nodes: ["pick"] } };
  expect(pagesAt(selections, "tasks/t.yaml", "pick", false)).toEqual(["bob"]);
  expect(pagesAt(selections, "tasks/t.yaml", "pick", true)).toEqual(["ann", "bob"]);
  expect(pagesAt(selections, "tasks/t.yaml", "/", true)).toEqual(["ann", "bob"]);
  expect(pagesAt({ ann: at("picking") }, "tasks/t.yaml", "pick", true)).toEqual([]);
  expect(pagesAt({ ann: at("/") }, "tasks/t.yaml", "/", true)).toEqual(["ann"]);
});

test("what is told begins with the focus and fits into one message", () => {
  expect(toTell("b", new Set(["a", "b"]))).toEqual(["b", "a"]);
  expect(toTell(null, new Set())).toEqual([]);
  expect(toTell(null, new Set(Array.from({ length: 500 }, (_, i) => `n${i}`)))).toHaveLength(64);
  const long = toTell(null, new Set(Array.from({ length: 64 }, (_, i) => `${"ü".repeat(60)}${i}`)));
  expect(long.length).toBeGreaterThan(3);
  expect(JSON.stringify({ type: "selection", task: "t".repeat(1024), nodes: long }).length).toBeLessThan(4096);
});

test("initials are two letters", () => {
  expect(["Viewer 2", "Ann Lee", "Bob", "x", ""].map(initials)).toEqual(["V2", "AL", "Bo", "x", "?"]);
});
