import { expect, test } from "vitest";

import { settingsOf } from "../src/model/values";
import { eventText, GROUPS, groupOf, processNotices, runText } from "../src/model/words";
import type { SessionView } from "../src/protocol/generated";
import { GROUP_SHAPES } from "../src/view/icons";
import { node } from "./tasks";

test("every group of leaves has a word and a drawing of its own", () => {
  const lists = ["containers", "tasks"];
  expect(Object.keys(GROUP_SHAPES).sort()).toEqual(Object.keys(GROUPS).filter((name) => !lists.includes(name)).sort());
  const shapes = Object.values(GROUP_SHAPES).map((shape) => JSON.stringify(shape.props));
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

const SESSION: SessionView = {
  state: "ended", task: "tasks/t.yaml", robot: "sim", target: "bt", seed: 0, pace: null, mocks: {}, run: "1", held: null,
  status: "stopped", outcome: null, message: "", contradiction: "", zombies: [], rest: "", unconfirmed: [],
};

test("after a stop it is told what was measured of the robot, loudly where nobody can say that it stands still", () => {
  expect(processNotices(null)).toEqual([]);
  expect(processNotices(SESSION)).toEqual([]);
  expect(processNotices({ ...SESSION, rest: "'right' is at rest" })).toEqual([{ text: "stopped; 'right' is at rest", bad: false }]);
  const rest = "could not confirm that 'right' stopped: no state comes";
  expect(processNotices({ ...SESSION, status: "error", message: "a: it broke", rest, unconfirmed: ["right"] })).toEqual([{ text: `error; ${rest}`, bad: true }]);
  const event = { seq: 9, t: 1, path: "/", event: "run_ended", outcome: null, code: null, data: { status: "stopped", rest } };
  expect(eventText(event)).toBe(`the run ended: stopped; ${rest}`);
});

test("a success that the referee contradicts is told as that", () => {
  const success = { ...SESSION, status: "success", outcome: "cleared" };
  const contradicted = { ...success, contradiction: "`placed == objects` isn't so; standing: box_0" };
  expect([processNotices(success), runText(success)]).toEqual([[], "success: cleared"]);
  expect(processNotices(contradicted)).toEqual([{ text: `the simulator's referee disagrees: ${contradicted.contradiction}`, bad: true }]);
  expect(runText(contradicted)).toBe("success: cleared, contradicted");
});

test("what is said meanwhile is no alert, and how a process died or was killed is one", () => {
  expect(processNotices({ ...SESSION, state: "running", status: null, message: "The run refused: no" })).toEqual([{ text: "The run refused: no", bad: false }]);
  for (const status of ["died", "killed"]) expect(processNotices({ ...SESSION, status, message: "gone" })).toEqual([{ text: "gone", bad: true }]);
  expect(processNotices({ ...SESSION, status: "success", message: "The run refused: it has ended" })).toEqual([]);
  expect(processNotices({ ...SESSION, run: null, status: "error", message: "before it began" })).toEqual([{ text: "before it began", bad: true }]);
  expect(processNotices({ ...SESSION, zombies: ["a (worker)"] }).map(({ bad }) => bad)).toEqual([true]);
});
