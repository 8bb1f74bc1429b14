import fc from "fast-check";
import { expect, test } from "vitest";

import { type Box, layoutTree, sizeOf } from "../src/model/layout";
import type { NodeView } from "../src/protocol/generated";
import { node, randomTree, SMALL } from "./tasks";

function overlap(a: Box, b: Box): boolean {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

test("no two nodes of any tree overlap", () => {
  fc.assert(
    fc.property(randomTree, (nodes) => {
      const boxes = [...layoutTree(nodes).values()];
      expect(boxes).toHaveLength(nodes.length);
      boxes.forEach((a, i) => boxes.slice(i + 1).forEach((b) => expect(overlap(a, b)).toBe(false)));
    }),
    { numRuns: 100 },
  );
});

test("children stand right of their parent, in their order, and the parent within their reach", () => {
  fc.assert(
    fc.property(randomTree, (nodes) => {
      const boxes = layoutTree(nodes);
      for (const parent of nodes.filter((n) => n.children.length > 0)) {
        const own = boxes.get(parent.path) as Box;
        const below = parent.children.map((child) => boxes.get(child) as Box);
        for (const box of below) expect(box.x).toBeGreaterThan(own.x + own.width);
        below.slice(1).forEach((box, i) => expect(box.y).toBeGreaterThan((below[i] as Box).y));
        const top = (below[0] as Box).y;
        const last = below.at(-1) as Box;
        const middle = own.y + own.height / 2;
        expect(middle).toBeGreaterThanOrEqual(top - 1);
        expect(middle).toBeLessThanOrEqual(last.y + last.height + 1);
      }
    }),
    { numRuns: 100 },
  );
});

test("nothing has a negative place, and the same tree has the same layout", () => {
  fc.assert(
    fc.property(randomTree, (nodes) => {
      const boxes = layoutTree(nodes);
      for (const box of boxes.values()) expect(Math.min(box.x, box.y)).toBeGreaterThanOrEqual(0);
      expect(layoutTree(structuredClone(nodes))).toEqual(boxes);
    }),
  );
});

test("a node with edges is taller, by the same for each edge", () => {
  const edge = (outcome: string) => ({ outcome, target: "x", ends: false });
  const heights = [0, 1, 2, 3].map((n) => sizeOf(node("a", { on: Array.from({ length: n }, (_, i) => edge(`${i}`)) })).height);
  expect(heights[1]).toBeGreaterThan(heights[0] as number);
  expect((heights[3] as number) - (heights[2] as number)).toBe((heights[2] as number) - (heights[1] as number));
});

test("an empty task has an empty layout", () => {
  expect(layoutTree([]).size).toBe(0);
  expect(layoutTree(SMALL.nodes).size).toBe(6);
});

test("ten thousand nodes are laid out within a second", () => {
  const nodes: NodeView[] = [node("/", { kind: "sequence", children: [] })];
  for (let i = 0; i < 100; i++) {
    const path = `g${i}`;
    (nodes[0] as NodeView).children.push(path);
    const children = Array.from({ length: 99 }, (_, j) => `${path}/l${j}`);
    nodes.push(node(path, { kind: "sequence", children }), ...children.map((child) => node(child)));
  }
  // Of the processor's time, which other programs take no part of, and at its best.
  const taken = [1, 2, 3].map(() => {
    const before = process.cpuUsage();
    expect(layoutTree(nodes).size).toBe(10_001);
    return process.cpuUsage(before).user / 1e6;
  });
  expect(Math.min(...taken)).toBeLessThan(1);
});
