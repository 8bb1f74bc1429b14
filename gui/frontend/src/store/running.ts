/** Starting and controlling runs from this page: what every button and key about runs does. */
import { PAGE, RefusedError, server } from "../protocol/client";
import type { Breakpoint, Control, StartRun } from "../protocol/generated";
import { askChoice, askText } from "./ask";
import { openTask, trying } from "./desk";
import { useDocument } from "./document";
import { save, settled, take } from "./editing";
import { usePage } from "./page";
import { useRun } from "./run";
import { breakpointsOf, useRunning } from "./runDesk";
import { loadProject } from "./tasks";

/** Do something that only who holds control may; where another page does, ask whether to take over. */
async function controlling(work: () => Promise<unknown>): Promise<void> {
  await trying(async () => {
    try {
      await work();
    } catch (error) {
      if (!(error instanceof RefusedError) || error.kind !== "held" || !(await askToTakeOver())) throw error;
      await takeOver();
      await work();
    }
  });
}

async function askToTakeOver(): Promise<boolean> {
  const options = [
    { value: "take", label: "Take over control", mark: "" },
    { value: "no", label: "Look on", mark: "" },
  ];
  return (await askChoice({ title: "Another page is in control", label: "It starts, pauses and steps runs. STOP always works.", options })) === "take";
}

export async function takeOver(): Promise<void> {
  useRunning.getState().setDesk(await server.lease({ page: PAGE, take: true, over: true }));
}

export function giveBack(): Promise<void> {
  return trying(async () => useRunning.getState().setDesk(await server.lease({ page: PAGE, take: false, over: false })));
}

/** Run the task that is open, or the one whose run is shown. */
export function start(where: Partial<Pick<StartRun, "begin_at" | "run_to">> = {}): Promise<void> {
  const { task, session } = useRun.getState();
  if (session !== null && session.state !== "ended") return Promise.resolve();
  return controlling(async () => {
    await sent;
    // An old run on display gives way to the task as it is now.
    if (useRun.getState().record !== null) await openTask(task.path);
    await settled();
    // What runs is the file: what was drawn is saved first, and a file that somebody else has changed asks.
    if (useDocument.getState().document?.saved === false && !(await save())) return;
    const { options, mocks } = useRunning.getState();
    const paths = new Set(useRun.getState().task.nodes.map((node) => node.path));
    const there = Object.fromEntries(Object.entries(mocks).filter(([node]) => paths.has(node)));
    // How it goes on is told by the socket alone: an answer may come later than newer news.
    await server.start({ task: task.path, ...options, mocks: there, begin_at: "", run_to: "", ...where, page: PAGE });
  });
}

export function control(command: Control["command"], more: Partial<Pick<Control, "how" | "node" | "when" | "fault">> = {}): Promise<void> {
  return controlling(() => server.control({ command, how: "tick", node: "", when: "before", fault: "", ...more, page: PAGE }));
}

export function stop(): void {
  const { session } = useRun.getState();
  if (session && session.state !== "ended") void control("stop");
}

export function pauseOrResume(): void {
  const state = useRun.getState().session?.state;
  if (state === "running") void control("pause");
  else if (state === "paused") void control("resume");
}

export function step(how: Control["how"]): void {
  const state = useRun.getState().session?.state;
  if (state === "paused" || state === "running") void control("step", { how });
}

const FAULTS: readonly (readonly [string, string])[] = [
  ["drop", "Drop what the hand holds"],
  ["abort", "Have controllers give up their motions"],
  ["blackout, lasts: 5", "Black out all cameras for 5 s"],
  ["freeze, lasts: 5", "Freeze all cameras for 5 s"],
  ["light, factor: 0.3, lasts: 5", "Dim the light for 5 s"],
];

/** Have something go wrong in the simulated world of the run under way. */
export async function injectFault(): Promise<void> {
  const { session } = useRun.getState();
  if (session === null || session.robot !== "sim" || (session.state !== "paused" && session.state !== "running")) {
    return useRun.getState().setError("Faults happen while a task runs in simulation.");
  }
  const options = [...FAULTS.map(([value, label]) => ({ value, label, mark: "" })), { value: "", label: "Something else ...", mark: "" }];
  let kind = await askChoice({ title: "What goes wrong", label: "It happens at once, in simulation", options });
  if (kind === "") {
    const text = await askText({ title: "What goes wrong", label: "As in a world's file: push, of: OBJECT, by: [0.3, 0, 0]", initial: "", check: (said) => (said.trim() === "" ? "a kind of fault is needed" : "") });
    kind = text === null ? null : text.trim().replace(/^\{?\s*(fault:)?\s*/, "").replace(/\}$/, "");
  }
  if (kind !== null) await control("fault", { fault: `from the page: {fault: ${kind}}` });
}

/** Go on to the selected node, in the run under way or in a new one. */
export function runToHere(): void {
  const node = usePage.getState().selected;
  const state = useRun.getState().session?.state;
  if (node === null) return;
  if (state === "paused" || state === "running") void control("run_to", { node });
  else void start({ run_to: node });
}

/** Begin at the selected node: what comes before it is passed over. On a real robot that is asked for. */
export async function runFromHere(): Promise<void> {
  const node = usePage.getState().selected;
  if (node === null) return;
  if (useRunning.getState().options.robot === "ros") {
    const options = [
      { value: "no", label: "Don't run", mark: "" },
      { value: "yes", label: `Run from ${node}`, mark: "" },
    ];
    const label = "The real robot moves at once; what comes before is passed over.";
    if ((await askChoice({ title: `Run from ${node}?`, label, options })) !== "yes") return;
  }
  await start({ begin_at: node });
}

// --- breakpoints ---

let sent: Promise<void> = Promise.resolve();

/** Shown at once, so that the next change starts from it; sent one after another, so that the last one stays. */
export function setBreakpoints(points: readonly Breakpoint[]): Promise<void> {
  const task = useRun.getState().task.path;
  const { desk, setDesk } = useRunning.getState();
  setDesk({ ...desk, breakpoints: { ...desk.breakpoints, [task]: [...points] } });
  sent = sent.then(() =>
    controlling(async () => {
      try {
        setDesk(await server.breakpoints({ task, breakpoints: [...points], page: PAGE }));
      } catch (error) {
        setDesk({ ...useRunning.getState().desk, breakpoints: desk.breakpoints });
        throw error;
      }
    }),
  );
  return sent;
}

/** Set a breakpoint before a node, or clear all of it. */
export function toggleBreakpoint(node: string | null = usePage.getState().selected): Promise<void> {
  if (node === null) return Promise.resolve();
  const points = breakpointsOf(useRunning.getState().desk, useRun.getState().task.path);
  const others = points.filter((point) => point.node !== node);
  return setBreakpoints(others.length < points.length ? others : [...points, { node, when: "before", outcome: null, condition: "" }]);
}

/** Look again whenever the window gets the focus, until the returned function is called. */
export function lookAgainOnReturn(): () => void {
  const look = (): void => void lookAgain().catch(() => {});
  window.addEventListener("focus", look);
  return () => window.removeEventListener("focus", look);
}

async function lookAgain(): Promise<void> {
  const { document, catalog, setCatalog } = useDocument.getState();
  const found = await server.catalog();
  if (JSON.stringify(found) !== JSON.stringify(catalog)) setCatalog(found);
  await loadProject();
  if (document === null) return;
  const now = await server.document(document.path);
  if (useDocument.getState().document?.path === now.path) take(now, "elsewhere");
}
