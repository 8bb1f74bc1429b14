import { expect, test } from "vitest";
import { sharing } from "../src/model/history";
import { layoutTree } from "../src/model/layout";
import { extent, foldedAtFirst, hasRoomForMap, idsIn, isInSight, linesIn, opened, unfolded } from "../src/model/visibility";
import type { NodeView, Problem } from "../src/protocol/generated";
import { SMALL } from "./tasks";

const [pattern] = SMALL.nodes as [NodeView];

function node(path: string, parent: string | null, children: string[]): NodeView {
  return { ...pattern, path, parent, name: path, children, on: [] };
}

/** A root with `groups` containers of `leaves` leaves each. */
function tree(groups: number, leaves: number): NodeView[] {
  const names = Array.from({ length: groups }, (_, g) => `g${g}`);
  const inside = (g: string): string[] => Array.from({ length: leaves }, (_, l) => `${g}/l${l}`);
  return [node("/", null, names), ...names.flatMap((g) => [node(g, "/", inside(g)), ...inside(g).map((l) => node(l, g, []))])];
}

test("a large task opens with its top alone, a small one whole", () => {
  expect(foldedAtFirst(tree(20, 20)).size).toBe(0);
  const large = tree(100, 30);
  expect(unfolded(large, foldedAtFirst(large)).length).toBe(101);
});

test("who selects a node inside folded containers sees it", () => {
  const large = tree(100, 30);
  const closed = opened(foldedAtFirst(large), ["g7/l3"]);
  expect(unfolded(large, closed).map((each) => each.path)).toContain("g7/l3");
  expect(unfolded(large, closed).length).toBe(131);
});

test("only what touches the part in sight is drawn, and everything is somewhere", () => {
  const nodes = tree(100, 10);
  const boxes = layoutTree(nodes);
  const whole = extent(boxes.values());
  expect(idsIn(whole, boxes).size).toBe(nodes.length);
  // Ten children have a line each; a hundred hang on one trunk, with the line that leads to it.
  expect(linesIn(whole, nodes, boxes).split("M").length - 1).toBe(nodes.length - 1 + 2);
  const top = { ...whole, bottom: 300 };
  const seen = idsIn(top, boxes);
  expect(seen.size).toBeGreaterThan(0);
  expect(seen.size).toBeLessThan(20);
});

test("of a parent with many children what is in sight hangs on a trunk, which is drawn as far as it is in sight", () => {
  const nodes = tree(3000, 0);
  const boxes = layoutTree(nodes);
  const whole = extent(boxes.values());
  const far = { ...whole, top: whole.bottom - 2000, bottom: whole.bottom - 1000 };
  const lines = linesIn(far, nodes, boxes).split("M").slice(1);
  expect(lines.length).toBeLessThanOrEqual(idsIn(far, boxes).size + 2);
  const reach = lines.flatMap((line) => /^\S+ (\S+)V(\S+)$/.exec(line)?.slice(1).map(Number) ?? []);
  expect(reach).toEqual([far.top, far.bottom]);
});

test("a node that an edit leaves as it was is the object that it was, and so is a task that stays the same", () => {
  const problem = (path: string): Problem => ({ path, code: "c", severity: "error", message: "", fix: "", line: null, column: null, key: [], fixes: [] });
  const before = { ...SMALL, nodes: tree(2, 2), problems: [problem("g0/l0"), problem("g1/l0")] };
  const copy = (nodes: NodeView[]): NodeView[] => structuredClone(nodes);
  expect(sharing({ ...before, nodes: copy(before.nodes), problems: [] }, before, false)).toBe(before);
  const nodes = [node("/", null, ["new", "g1"]), node("new", "/", []), ...copy(before.nodes.slice(4))];
  const next = sharing({ ...before, nodes, problems: [] }, before, false);
  expect(next.nodes.map((each) => each.path)).toEqual(["/", "new", "g1", "g1/l0", "g1/l1"]);
  expect(next.nodes[2]).toBe(before.nodes[4]);
  expect(next.problems.map(({ path }) => path)).toEqual(["g1/l0"]);
  expect(sharing({ ...before, nodes, problems: [] }, before, true).problems).toEqual([]);
});

test("a node is in sight where all of it is in the pane, and not below the map in the corner", () => {
  const box = { x: 100, y: 50, width: 200, height: 40 };
  const at = (x: number, y: number, mapped = false): boolean => isInSight(box, { x, y, zoom: 1 }, 600, 400, mapped);
  expect(at(0, 0)).toBe(true);
  expect(at(-101, 0)).toBe(false);
  expect(at(301, 0)).toBe(false);
  expect(at(0, 311)).toBe(false);
  expect(at(300, 310)).toBe(true);
  expect(at(300, 310, true)).toBe(false);
  expect(at(300, 190, true)).toBe(true);
  expect(isInSight(box, { x: 0, y: 0, zoom: 2.1 }, 600, 400, false)).toBe(false);
  expect([327, 480].map(hasRoomForMap)).toEqual([false, true]);
});
