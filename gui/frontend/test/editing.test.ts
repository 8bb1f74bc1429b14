import { afterEach, expect, test, vi } from "vitest";
import { whereNow } from "../src/model/history";
import type { DocumentView, NodeView } from "../src/protocol/generated";
import { useDocument } from "../src/store/document";
import { edit, take } from "../src/store/editing";
import { usePage } from "../src/store/page";
import { SMALL } from "./tasks";

const answers = vi.hoisted(() => ({ give: (_: unknown): void => {} }));
vi.mock("../src/protocol/client", () => ({
  RefusedError: class extends Error {},
  server: { edit: () => new Promise((resolve) => (answers.give = resolve)), problems: () => new Promise(() => {}), forms: () => new Promise(() => {}) },
}));
afterEach(() => vi.useRealTimers());

const [pattern] = SMALL.nodes as [NodeView];
const node = (path: string, parent: string | null, children: string[]): NodeView => ({ ...pattern, path, parent, name: path, children, on: [] });
const BEFORE = [node("/", null, ["a", "box"]), node("a", "/", []), node("box", "/", ["box/b", "box/c"]), node("box/b", "box", []), node("box/c", "box", [])];

const OPEN: DocumentView = { path: "t.yaml", revision: 1, text: "", saved: true, draft: false, checked: true, change: "", moved: {}, layout: { flow: {}, tree: {} }, history: { at: 0, moments: [], can_undo: false, can_redo: false }, task: { ...SMALL, nodes: BEFORE } };

/** A document with a root, `a`, and `box` with two leaves. */
function open(): void {
  useDocument.setState({ document: null });
  take(OPEN);
  usePage.setState({ closed: new Set(), opened: new Set(), container: "/" });
}

/** `box` is wrapped in `late`. */
const INSIDE = [node("late", "/", ["late/box"]), node("late/box", "late", ["late/box/b", "late/box/c"]), node("late/box/b", "late/box", []), node("late/box/c", "late/box", [])];
const WRAPPED: DocumentView = { ...OPEN, revision: 2, checked: false, moved: { box: "late/box" }, task: { ...OPEN.task, nodes: [node("/", null, ["a", "late"]), node("a", "/", []), ...INSIDE] } };

async function wrapped(meanwhile: () => void): Promise<ReturnType<typeof usePage.getState>> {
  vi.useFakeTimers(); // what is asked for afterwards isn't
  open();
  usePage.getState().select("box");
  const done = edit({ do: "wrap", paths: ["box"], kind: "timeout", name: "late", fields: {} }, "late");
  await Promise.resolve();
  meanwhile();
  answers.give(WRAPPED);
  expect(await done).toBe(true);
  return usePage.getState();
}

test("what an edit has made is selected where nobody has turned to anything else", async () => {
  expect((await wrapped(() => {})).selected).toBe("late");
});

test("what was picked while an edit was under way stays selected", async () => {
  expect((await wrapped(() => usePage.getState().select("a"))).selected).toBe("a");
});

test("the node that was selected before is a choice too", async () => {
  const { selected, marked } = await wrapped(() => {
    usePage.getState().select("a");
    usePage.getState().select("box");
  });
  expect(selected).toBe("late/box");
  expect([...marked]).toEqual(["late/box"]);
});

test("what was picked stays where the edit takes it, several nodes too", async () => {
  const { selected, marked } = await wrapped(() => {
    usePage.getState().select("box/b");
    usePage.getState().mark("box/c");
    usePage.getState().mark("a");
  });
  expect(selected).toBe("a");
  expect([...marked].sort()).toEqual(["a", "late/box/b", "late/box/c"]);
});

test("what is folded, opened in place or shown as a chart follows an edit as well", async () => {
  const { closed, opened, container } = await wrapped(() => usePage.setState({ closed: new Set(["box"]), opened: new Set(["box"]), container: "box" }));
  expect([...opened]).toEqual(["late/box"]);
  expect(container).toBe("late/box");
  expect([...closed]).toEqual(["late/box"]);
});

test("where nodes are that were moved with those above them, into the root's place or away from it", () => {
  const known = new Map(["/", "x", "l/m", "l/m/a", "b"].map((path) => [path, true]));
  expect(whereNow("x", known, { x: "b" })).toBe("x");
  expect(whereNow("m/a", known, { m: "l/m" })).toBe("l/m/a");
  expect(whereNow("m/b", known, { m: "l/m", "m/b": "b" })).toBe("b");
  expect(whereNow("m/gone", known, { m: "l/m" })).toBe("m/gone");
  expect(whereNow("only/x", new Map([["/", true], ["x2", true]]), { only: "/" })).toBe("only/x");
  expect(whereNow("only/x2", new Map([["/", true], ["x2", true]]), { only: "/" })).toBe("x2");
});
