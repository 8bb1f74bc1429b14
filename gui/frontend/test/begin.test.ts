import { expect, test } from "vitest";

import { firstTask, lackingFor, NEW_CAMERA, NEW_COMPONENT, partsOf, toBeMade } from "../src/model/parts";

const WHOLE = { robot: { moveit: "src/arm" }, arms: { left: {}, right: {} }, hands: { palm: {} }, sensors: { top: {} }, world: "bench" };

test("what a project has is told part by part, also of a file that is empty or no mapping", () => {
  const names = (data: unknown, tasks: readonly string[] = []) => Object.fromEntries(partsOf(data, tasks).map((part) => [part.what, part.names]));
  expect(names(WHOLE, ["tasks/take.yaml", "tasks/more/two.yml"])).toEqual({ robot: ["from files"], arms: ["left", "right"], hands: ["palm"], sensors: ["top"], world: ["bench"], tasks: ["take", "more/two"] });
  const nothing = { robot: [], arms: [], hands: [], sensors: [], world: [], tasks: [] };
  for (const data of [null, undefined, "text", [], { grip: 1 }, { robot: {}, arms: null, world: 3 }]) expect(names(data)).toEqual(nothing);
  expect(names({ robot: "panda" }).robot).toEqual(["panda"]);
});

test("a node lacks what the project has none of, and nothing else", () => {
  const none = partsOf({ robot: "panda" }, []);
  for (const [node, what] of [["arm/move_to", "arms"], ["grasp/choose", "arms"], ["hand/open", "hands"], ["sensor/overhead", "sensors"]] as const) {
    expect(lackingFor(node, none)?.what).toBe(what);
    expect(lackingFor(node, partsOf(WHOLE, []))).toBeNull();
  }
  for (const node of ["flow/wait", "sequence", "component/seer", "tasks/arm/move.yaml"]) expect(lackingFor(node, none)).toBeNull();
});

test("a camera is offered where no sensor is there, a component always", () => {
  expect(toBeMade([{ id: "arm/move_to" }]).map((face) => face.id)).toEqual([NEW_CAMERA, NEW_COMPONENT]);
  expect(toBeMade([{ id: "sensor/left" }]).map((face) => face.id)).toEqual([NEW_COMPONENT]);
});

test("the task in which a hand holds something comes first", () => {
  expect(firstTask(["tasks/first.yaml", "tasks/take.yaml"])).toBe("tasks/take.yaml");
  expect(firstTask(["tasks/a.yaml"])).toBe("tasks/a.yaml");
  expect(firstTask([])).toBeUndefined();
});
