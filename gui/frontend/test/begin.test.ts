import { expect, test } from "vitest";

import { firstTask, lackingFor, NEW_CAMERA, NEW_COMPONENT, partsOf, posesOf, standsOf, toBeMade } from "../src/model/parts";
import { pathAt, pathFrom } from "../src/model/shapes";

const WHOLE = { robot: { moveit: "src/arm" }, arms: { left: {}, right: {} }, hands: { palm: {} }, sensors: { top: {} }, world: "bench" };

test("what a project has is told part by part, also of a file that is empty or no mapping", () => {
  const names = (data: unknown, tasks: readonly string[] = []) => Object.fromEntries(partsOf(data, tasks).map((part) => [part.what, part.names]));
  expect(names(WHOLE, ["tasks/take.yaml", "tasks/more/two.yml"])).toEqual({ robot: ["from files"], arms: ["left", "right"], hands: ["palm"], sensors: ["top"], world: ["bench"], tasks: ["take", "more/two"] });
  const nothing = { robot: [], arms: [], hands: [], sensors: [], world: [], tasks: [] };
  for (const data of [null, undefined, "text", [], { grip: 1 }, { robot: {}, arms: null, world: 3 }]) expect(names(data)).toEqual(nothing);
  expect(names({ robot: "panda" }).robot).toEqual(["panda"]);
  expect(names({ robot: { arm: "ur5", hand: "shadow_right", mount: {} } }).robot).toEqual(["ur5 with shadow_right"]);
  expect(names({ robot: { ready: "panda", states: {} } }).robot).toEqual(["panda"]);
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

test("paths are browsed for wherever a form asks for one, and said from where its file lies", () => {
  const fits = (key: string, name: string): boolean | undefined => pathAt(key.split("/"))?.test(name);
  expect(fits("robot/xacro", "arm.urdf.xacro")).toBe(true);
  expect(fits("robot/srdf", "arm.srdf")).toBe(true);
  expect(fits("robot/arm", "arm.urdf")).toBe(true);
  expect(fits("processes/bringup/launch", "robot.launch.py")).toBe(true);
  expect(fits("start/launch", "notes.py")).toBe(false);
  expect(fits("fixtures/shelf/mesh", "shelf.STL")).toBe(true);
  expect(pathAt(["robot", "moveit"])).toBeNull();
  expect(pathAt(["robot", "packages", "arm_description"])).toBeNull();
  for (const key of ["arms/right/hand", "world", "sensors/top/camera", "robot/name"]) expect(pathAt(key.split("/"))).toBeUndefined();
  expect(pathFrom("/ws/project", "/ws/src/arm")).toBe("../src/arm");
  expect(pathFrom("/ws/project/worlds", "/ws/project/worlds/shelf.stl")).toBe("shelf.stl");
  expect(pathFrom("/ws/project", "/ws/project")).toBe(".");
});

test("named poses and joint states are drawn as far as they are whole", () => {
  const half = Math.SQRT1_2;
  const found = posesOf({
    above: { reference_frame: "world", position: { x: 0.4, y: 0, z: 0.2 }, orientation: { r: 0, p: 0, y: Math.PI / 2 } },
    both: { reference_frame: "table", left: { position: { x: 1, y: 2, z: 3 }, orientation: { x: 0, y: 0, z: 0, w: 1 } }, right: {} },
    typed: { reference_frame: "world", position: { x: 0.4 } },
    empty: null,
  });
  expect(found.map(({ name, frame }) => [name, frame])).toEqual([["above", "world"], ["both/left", "table"]]);
  [0.4, 0, 0.2, half, 0, 0, half].forEach((number, at) => expect(found[0]?.at[at]).toBeCloseTo(number));
  expect(found[1]?.at).toEqual([1, 2, 3, 1, 0, 0, 0]);
  for (const data of [null, "text", []]) expect(posesOf(data)).toEqual([]);
  expect(standsOf({ home: { a: 1 }, broken: { a: "one" }, none: null })).toEqual({ home: { a: 1 } });
});
