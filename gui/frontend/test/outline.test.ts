import { expect, test } from "vitest";

import { outlineKey, visibleRows } from "../src/model/visibility";
import { spansOf } from "../src/model/timeline";
import { TaskIndex } from "../src/model/status";
import { statusText } from "../src/model/words";
import { event, SMALL } from "./tasks";

const OPEN: ReadonlySet<string> = new Set();

test("rows are in document order with their levels and places", () => {
  const rows = visibleRows(SMALL.nodes, OPEN);
  expect(rows.map((row) => [row.node.path, row.level, row.position, row.siblings])).toEqual([
    ["/", 1, 1, 1],
    ["a", 2, 1, 2],
    ["again", 2, 2, 2],
    ["again/both", 3, 1, 1],
    ["again/both/x", 4, 1, 2],
    ["again/both/y", 4, 2, 2],
  ]);
});

test("what is in a closed container can't be seen", () => {
  expect(visibleRows(SMALL.nodes, new Set(["again"])).map((row) => row.node.path)).toEqual(["/", "a", "again"]);
});

test("keys walk the tree as the ARIA pattern says", () => {
  const rows = visibleRows(SMALL.nodes, OPEN);
  const closed = new Set(["again"]);
  const few = visibleRows(SMALL.nodes, closed);
  expect(outlineKey("ArrowDown", "a", rows, OPEN)).toEqual({ go: "again" });
  expect(outlineKey("ArrowUp", "/", rows, OPEN)).toBeNull();
  expect(outlineKey("ArrowRight", "again", rows, OPEN)).toEqual({ go: "again/both" });
  expect(outlineKey("ArrowRight", "again", few, closed)).toEqual({ open: "again" });
  expect(outlineKey("ArrowLeft", "again", rows, OPEN)).toEqual({ close: "again" });
  expect(outlineKey("ArrowLeft", "a", rows, OPEN)).toEqual({ go: "/" });
  expect(outlineKey("End", "/", rows, OPEN)).toEqual({ go: "again/both/y" });
  expect(outlineKey("x", "/", rows, OPEN)).toBeNull();
});

test("bars show leaves only, and those that overlap get lanes of their own", () => {
  const events = [
    event(0, "/", "enter"),
    event(1, "a", "enter"),
    event(2, "again/both/x", "enter"),
    event(3, "a", "exit", { outcome: "none" }),
    event(4, "again/both/y", "enter"),
  ];
  const spans = spansOf(events, new TaskIndex(SMALL));
  expect(spans.map(({ path, lane, phase }) => [path, lane, phase])).toEqual([
    ["a", 0, "failure"],
    ["again/both/x", 1, "running"],
    ["again/both/y", 0, "running"],
  ]);
  expect(spans[0]).toMatchObject({ from: 0.5, to: 1.5 });
});

test("a status says label, code and meaning in words", () => {
  const base = { since: 0, activations: 1 };
  expect(statusText({ ...base, phase: "failure", outcome: "failure", code: "no_plan" })).toBe("failure.no_plan");
  expect(statusText({ ...base, phase: "failure", outcome: "none" })).toBe("none (failure)");
  expect(statusText({ ...base, phase: "success", outcome: "success" })).toBe("success");
  expect(statusText({ ...base, phase: "running" })).toBe("running");
});
