import fc from "fast-check";
import { expect, test } from "vitest";

import { History } from "../src/model/history";
import { spansOf } from "../src/model/timeline";
import { TaskIndex, variableKey } from "../src/model/status";
import { eventText } from "../src/model/words";
import type { RunEvent } from "../src/protocol/generated";
import { event, SMALL } from "./tasks";

function played(events: RunEvent[]): History {
  const history = new History(new TaskIndex(SMALL));
  history.add(events);
  return history;
}

test("an outcome shows what it means to the task", () => {
  const history = played([
    event(0, "/", "enter"),
    event(1, "a", "enter"),
    event(2, "a", "exit", { outcome: "none", code: "no_data", data: { message: "nothing seen" } }),
  ]);
  expect(history.at(2).status("a").phase).toBe("running");
  expect(history.now().status("a")).toMatchObject({
    phase: "failure",
    outcome: "none",
    code: "no_data",
    message: "nothing seen",
  });
  expect(history.now().status("/").phase).toBe("running");
});

test("what happens inside a subtask is said at the subtask, and leaves its phase alone", () => {
  const history = played([event(0, "a", "enter"), event(1, "a/sub/inner", "enter"), event(2, "a/sub/inner", "exit", { outcome: "failure", code: "no_plan" })]);
  expect(history.at(2).status("a")).toMatchObject({ phase: "running", message: "sub/inner: running", activations: 1 });
  expect(history.now().status("a")).toMatchObject({ phase: "running", message: "sub/inner: failure.no_plan" });
  expect(history.now().nodes.has("a/sub/inner")).toBe(false);
});

test("a container that starts again forgets what was below it and counts its activations", () => {
  const history = played([
    event(0, "again", "enter"),
    event(1, "again/both", "enter"),
    event(2, "again/both/x", "enter"),
    event(3, "again/both/x", "exit", { outcome: "failure" }),
    event(4, "again/both", "exit", { outcome: "failure" }),
    event(5, "again/both", "enter"),
  ]);
  expect(history.now().status("again/both/x").phase).toBe("idle");
  expect(history.now().status("again/both")).toMatchObject({ phase: "running", activations: 2 });
});

test("a write reaches the nearest declaration above the writer", () => {
  const write = (preview: string) => ({ data: { variable: "v", type: "int", preview } });
  const history = played([event(0, "a", "write", write("1")), event(1, "again/both/x", "write", write("2"))]);
  expect(history.now().variables.get(variableKey("", "v"))).toMatchObject({ preview: "1", writer: "a" });
  expect(history.now().variables.get(variableKey("again", "v"))).toMatchObject({ preview: "2", writer: "again/both/x" });
});

test("an error marks its node and ends the run for all", () => {
  const history = played([
    event(0, "/", "enter"),
    event(1, "a", "enter"),
    event(2, "a", "error", { data: { type: "KeyError", message: "'x'", traceback: "..." } }),
    event(3, "/", "run_ended", { data: { status: "error" } }),
  ]);
  expect(history.now().status("a").phase).toBe("error");
  expect(history.now().status("/").phase).toBe("interrupted");
  expect(history.now().facts).toMatchObject({ state: "ended", status: "error", error: { path: "a" } });
});

test("a run whose process died ends in the view, once", () => {
  const history = played([event(0, "/", "enter"), event(1, "a", "enter")]);
  history.close();
  history.close();
  expect(history.length).toBe(3);
  expect(history.now().facts).toMatchObject({ state: "ended", status: "lost" });
  expect(history.now().status("a").phase).toBe("interrupted");
});

test("events that come twice count once", () => {
  const events = [event(0, "/", "enter"), event(1, "a", "enter")];
  const history = played(events);
  history.add(events);
  expect(history.length).toBe(2);
  expect(history.now().status("a").activations).toBe(1);
});

const paths = SMALL.nodes.map((node) => node.path);
const randomRun: fc.Arbitrary<RunEvent[]> = fc
  .array(fc.record({ path: fc.constantFrom(...paths), kind: fc.constantFrom("enter", "exit", "interrupted", "message", "write") }), {
    maxLength: 700,
  })
  .map((picks) =>
    picks.map(({ path, kind }, seq) =>
      event(seq, path, kind, {
        outcome: kind === "exit" ? "success" : null,
        data: { variable: "v", type: "int", preview: String(seq), text: String(seq) },
      }),
    ),
  );

test("any moment reached by scrubbing is the one that was live then", () => {
  fc.assert(
    fc.property(randomRun, fc.nat(), (events, pick) => {
      const count = pick % (events.length + 1);
      const scrubbed = played(events).at(count);
      const live = played(events.slice(0, count)).now();
      expect(scrubbed.nodes).toEqual(live.nodes);
      expect(scrubbed.variables).toEqual(live.variables);
      expect(scrubbed.facts).toEqual(live.facts);
    }),
    { numRuns: 60 },
  );
});

test("a later event never changes a moment that was taken before", () => {
  const history = played([event(0, "a", "enter")]);
  const before = history.at(1);
  history.add([event(1, "a", "exit", { outcome: "one" })]);
  expect(before.status("a").phase).toBe("running");
});

test("times count from the start of the run, whatever its clock says", () => {
  const history = played([event(0, "a", "enter", { t: 90 }), event(1, "a", "exit", { t: 91.5, outcome: "one" })]);
  history.close();
  expect(history.events.map((e) => e.t)).toEqual([0, 1.5, 1.5]);
  expect(history.now().status("a").since).toBe(1.5);
});

test("the number of events at a time is found", () => {
  const history = played([event(0, "/", "enter"), event(1, "a", "enter"), event(2, "a", "exit", { outcome: "one" })]);
  expect([-1, 0, 0.4, 0.5, 1, 9].map((t) => history.countAt(t))).toEqual([0, 1, 1, 2, 3, 3]);
});

test("what ran when the run's process died runs on when somebody goes on with the run", () => {
  const history = played([
    event(0, "/", "enter"),
    event(1, "a", "enter"),
    event(2, "a", "error", { data: { type: "ProcessDied", message: "SIGKILL" } }),
    event(3, "/", "run_ended", { data: { status: "error" } }),
    event(4, "/", "run_resumed", { data: { restored: { scene: 3, world: 3 } } }),
    event(5, "a", "went_on", { data: { how: "restart" } }),
    event(6, "a", "exit", { outcome: "one" }),
  ]);
  expect(history.at(4).facts.state).toBe("ended");
  expect(history.at(4).status("a").phase).toBe("error");
  expect(history.at(4).status("/").phase).toBe("interrupted");
  const on = history.at(6);
  expect(on.facts).toEqual({ state: "running" });
  expect([on.status("/").phase, on.status("a").phase]).toEqual(["running", "running"]);
  expect(history.now().status("a").outcome).toBe("one");
  expect(history.events.slice(4, 6).map(eventText)).toEqual([
    "the run resumes in another process; as before: scene, world",
    "is started again",
  ]);
  expect(spansOf(history.events, new TaskIndex(SMALL)).filter((span) => span.path === "a")).toHaveLength(2);
});
