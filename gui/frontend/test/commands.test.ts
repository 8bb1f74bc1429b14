import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { addNew, childNames, connectingFree, freshName, moving, newLeaf, pasting, spotFor, topmost } from "../src/model/commands";
import { TaskIndex } from "../src/model/status";
import type { CatalogView } from "../src/protocol/generated";
import { node, randomTree, SMALL, task } from "./tasks";

const index = new TaskIndex(SMALL);
const MACHINE = task([
  node("/", { kind: "state_machine", children: ["a", "b"], outcomes: { done: "success", failure: "failure" } }),
  node("a", { on: [{ outcome: "failure", target: "failure", ends: true }] }),
  node("b"),
]);
const machine = new TaskIndex(MACHINE);
const CATALOG: CatalogView = {
  error: "",
  tasks: [{ id: "tasks/fetch.yaml", doc: "", parameters: [], inputs: [], outputs: [], outcomes: { done: "success" }, codes: [] }],
  nodes: [
    {
      id: "eye/find",
      doc: "",
      parameters: [],
      inputs: [{ name: "cloud", type: "PointCloud", doc: "", required: true }],
      outputs: [{ name: "grasps", type: "list[Grasp]", doc: "", required: false }],
      outcomes: { success: "success" },
      codes: [],
    },
  ],
};

describe("where something new goes", () => {
  it("goes into the selected container, after a selected leaf, and out of decorators", () => {
    expect(spotFor(index.byPath, "/")).toEqual({ parent: "/", index: 2 });
    expect(spotFor(index.byPath, "a")).toEqual({ parent: "/", index: 1 });
    expect(spotFor(index.byPath, "again")).toEqual({ parent: "/", index: 2 });
    expect(spotFor(index.byPath, "again/both/x")).toEqual({ parent: "again/both", index: 1 });
    expect(spotFor(new TaskIndex(task([node("/")])).byPath, "/")).toBeNull();
  });

  it("gets a name that is free", () => {
    expect(freshName(["a"], "b")).toBe("b");
    expect(freshName(["a", "a_2"], "a")).toBe("a_3");
    expect(freshName([], "not/a.name")).toBe("node");
    const { command, path } = addNew(SMALL, index.byPath, CATALOG, "sequence", { parent: "/", index: 0 });
    expect(path).toBe("sequence");
    expect(command).toEqual({ do: "add", parent: "/", name: "sequence", node: { kind: "sequence", children: {} }, index: 0 });
  });

  it("may be another task of the project", () => {
    const { command, path } = addNew(SMALL, index.byPath, CATALOG, "tasks/fetch.yaml", { parent: "/", index: 0 });
    expect(path).toBe("fetch");
    expect(command["node"]).toEqual({ kind: "subtask", task: "tasks/fetch.yaml" });
  });

  it("binds the ports for which one variable can be meant, and no other", () => {
    const face = CATALOG.nodes[0]!;
    expect(newLeaf(face, new Map([["points", "PointCloud"]]))).toEqual({ node: "eye/find", in: { cloud: "points" } });
    expect(newLeaf(face, new Map([["p", "PointCloud"], ["q", "PointCloud"]]))).toEqual({ node: "eye/find" });
    expect(newLeaf(face, new Map([["p", "PointCloud"], ["cloud", "PointCloud"], ["grasps", "list[Grasp]"]]))).toEqual({
      node: "eye/find",
      in: { cloud: "cloud" },
      out: { grasps: "grasps" },
    });
  });
});

describe("several nodes", () => {
  it("are those that are in no other selected one, in the order of the task", () => {
    expect(topmost(SMALL, ["again/both/y", "again/both", "a"])).toEqual(["a", "again/both"]);
    expect(topmost(SMALL, ["/", "a"])).toEqual(["/"]);
  });

  it("move to a place that counts without themselves", () => {
    const { command, paths } = moving(index.byPath, ["a"], { parent: "/", index: 2 });
    expect(command).toEqual({ do: "move", path: "a", parent: "/", index: 1, name: null });
    expect(paths).toEqual(["a"]);
  });

  it("count those that haven't moved yet", () => {
    const tree = new TaskIndex(task([node("/", { children: ["a", "b", "c", "d"] }), node("a"), node("b"), node("c"), node("d")]));
    const { command } = moving(tree.byPath, ["a", "b"], { parent: "/", index: 3 });
    expect((command["commands"] as { index: number }[]).map(({ index }) => index)).toEqual([2, 2]);
  });

  it("move in their order, whatever they are: simulated on lists", () => {
    fc.assert(
      fc.property(randomTree, fc.nat(), fc.nat(), fc.array(fc.nat(), { minLength: 1, maxLength: 4 }), (nodes, pick, at, picks) => {
        const tree = task(nodes);
        const { byPath } = new TaskIndex(tree);
        const parents = nodes.filter((each) => each.children.length > 0);
        const parent = parents[pick % Math.max(1, parents.length)];
        if (!parent) return;
        const chosen = topmost(tree, picks.map((p) => parent.children[p % parent.children.length] as string));
        const index = at % (parent.children.length + 1);
        const { command } = moving(byPath, chosen, { parent: parent.path, index });
        const list = [...parent.children];
        const marker = "#here";
        const expected = [...list.slice(0, index), marker, ...list.slice(index)].filter((path) => !chosen.includes(path)).flatMap((path) => (path === marker ? chosen : [path]));
        const commands = (command.do === "group" ? command["commands"] : [command]) as { path: string; index: number }[];
        for (const { path, index: to } of commands) {
          list.splice(list.indexOf(path), 1);
          list.splice(to, 0, path);
        }
        expect(list).toEqual(expected);
      }),
    );
  });

  it("are pasted under free names, with the edges between them", () => {
    const parts = [
      { name: "a", node: { node: "x/y", on: { success: "b" } }, variables: {} },
      { name: "b", node: { node: "x/y" }, variables: {} },
    ];
    const { command, paths } = pasting(machine.byPath, parts, { parent: "/", index: 2 });
    expect(paths).toEqual(["a_2", "b_2"]);
    const commands = command["commands"] as Record<string, unknown>[];
    expect(commands.map((each) => each["do"])).toEqual(["paste", "paste", "connect"]);
    expect(commands[2]).toEqual({ do: "connect", path: "a_2", outcome: "success", target: "b_2" });
  });
});

it("free outcomes lead to the next node or to an end of their meaning", () => {
  expect(connectingFree(machine.byPath, "/")).toEqual({
    do: "group",
    title: "connect free outcomes",
    commands: [
      { do: "connect", path: "a", outcome: "success", target: "b" },
      { do: "connect", path: "b", outcome: "success", target: "done" },
      { do: "connect", path: "b", outcome: "failure", target: "failure" },
    ],
  });
  expect(connectingFree(index.byPath, "/")).toBeNull();
  expect(childNames(machine.byPath, "/")).toEqual(["a", "b"]);
});
