/** How a project begins: with a robot, a task from elsewhere, or an example; and what it lacks, which can be added. */
import { create } from "zustand";

import { lackingFor, NEEDS, NEW_COMPONENT, type Part, partsOf } from "../model/parts";
import { valueAt } from "../model/shapes";
import { server } from "../protocol/client";
import type { BeginView, GeometryView } from "../protocol/generated";
import { askChoice, type Option } from "./ask";
import { openTask } from "./desk";
import { setRobotOpen, useRobot } from "./live";
import { goToTree, usePage } from "./page";
import { useRun } from "./run";
import { openSetup, refreshed, removeValue, report, saveSetup, setValue, isDirty, useSetup } from "./setup";
import { useProject } from "./tasks";

export interface BeginStore {
  /** What is being done, in words; empty for nothing. */
  readonly busy: string;
  readonly error: string;
  /** What was written, once it was. */
  readonly made: BeginView | null;
  /** Whether a robot is being chosen for a project that has begun. */
  readonly choosing: boolean;
  /** The node that was to be added when it showed what is missing, and how that goes on. */
  readonly wanted: { readonly node: string; readonly add: (node: string) => Promise<void> } | null;
}

export const useBegin = create<BeginStore>()(() => ({ busy: "", error: "", made: null, choosing: false, wanted: null }));

async function working<T>(busy: string, work: () => Promise<T>): Promise<T | null> {
  useBegin.setState({ busy, error: "" });
  try {
    return await work();
  } catch (error) {
    useBegin.setState({ error: error instanceof Error ? error.message : String(error) });
    return null;
  } finally {
    useBegin.setState({ busy: "" });
  }
}

/** Have the server write what a project for a robot lacks; where the robot has several configurations, ask first. */
export async function begin(robot: string, chosen: readonly string[] = []): Promise<boolean> {
  if (isDirty() && !(await saveSetup())) return false;
  const said = robot === "" ? "Adding what the robot has ..." : `Reading ${robot.split("/").at(-1)}, and looking for what it can reach ...`;
  const made = await working(said, () => server.begin({ robot, example: "", chosen: [...chosen] }));
  if (made === null) return false;
  if (made.choices.length > 0) {
    const options = made.choices.map((name) => ({ value: name, label: name }));
    const answer = await askChoice({ title: "Which configuration?", label: made.question, options, search: true });
    return answer !== null && (await begin(robot, [...chosen, answer]));
  }
  await reread();
  useBegin.setState({ made });
  return true;
}

/** The files are others now. */
async function reread(): Promise<void> {
  const { view } = useSetup.getState();
  if (view !== null) useSetup.setState({ view: null, saved: "" });
  await refreshed();
  await openSetup(view?.path ?? "grip.yaml");
}

export async function openExample(task: string): Promise<void> {
  const made = await working("Copying the example project ...", () => server.begin({ robot: "", example: task, chosen: [] }));
  if (made === null) return;
  await reread();
  await openFirst(made.files[0] ?? "");
}

/** Show a task, and the robot beside it. */
export async function openFirst(path: string): Promise<void> {
  try {
    await openTask(path);
    leaveBeginning();
    usePage.getState().setRoom("task");
    setRobotOpen(true);
    goToTree();
  } catch (error) {
    report(error);
  }
}

/**
 * Before a node is added: offer to make what it needs. Returns whether it shall be added.
 * @param add adds it, once what it needs was made elsewhere.
 */
export async function provided(node: string, add: (node: string) => Promise<void>): Promise<boolean> {
  if (node === NEW_COMPONENT) {
    useBegin.setState({ wanted: { node, add } });
    usePage.getState().setRoom("project");
    useSetup.setState({ making: "component" });
    return false;
  }
  if (!NEEDS.some(([pattern]) => pattern.test(node))) return true;
  const tasks = useProject.getState().project?.tasks.map((task) => task.path) ?? [];
  const file = await server.setupFile("grip.yaml").catch(() => null);
  const parts = partsOf(file?.data, tasks);
  const lacking = file === null ? null : lackingFor(node, parts);
  if (lacking === null) return true;
  const robot = parts.some((part) => part.what === "robot" && part.names.length > 0);
  const options: Option[] = [
    robot ? { value: "add", label: `Add the robot's ${lacking.word}`, detail: "Written into grip.yaml, with whatever else is missing" } : { value: "choose", label: "Choose a robot", detail: "It comes with arms, hands, a camera and a world" },
    { value: "anyway", label: "Add the node all the same" },
  ];
  const answer = await askChoice({ title: `The project has no ${lacking.word} yet`, label: `${node} needs one`, options });
  if (answer === "choose") {
    chooseRobot();
    useBegin.setState({ wanted: { node, add } });
  }
  return answer === "anyway" || (answer === "add" && (await added(lacking.what)));
}

/** Add what the robot has; what keeps it from that is said. A hand that an arm doesn't have, or an arm below a hand, is chosen among the ready-made. */
export async function added(what: Part["what"] = "robot"): Promise<boolean> {
  const done = await begin("");
  const { error } = useBegin.getState();
  if (error) useRun.getState().setError(error);
  return done && ((what !== "hands" && what !== "arms") || (await joined(what)));
}

const whatIsThere = async (): Promise<unknown> => (await server.setupFile("grip.yaml")).data;

/** Where the project still has no hands, or no arms: ask which, and put them together with what there is. */
async function joined(what: "hands" | "arms"): Promise<boolean> {
  const data = await whatIsThere();
  const robot = valueAt(data, ["robot"]);
  if (partsOf(data, []).some((part) => part.what === what && part.names.length > 0) || robot === undefined) return true;
  const [lacks, has] = what === "hands" ? (["hand", "arm"] as const) : (["arm", "hand"] as const);
  const [pairs, docs] = await Promise.all([server.pairs(), server.robots()]);
  const made = Object.entries(pairs).filter(([, pair]) => pair[has] === robot);
  const others = [...new Set(Object.values(pairs).map((pair) => pair[lacks]))].filter((name) => !made.some(([, pair]) => pair[lacks] === name));
  const options: Option[] = [
    ...made.map(([name, pair]) => ({ value: name, label: pair[lacks], detail: docs[name] ?? "" })),
    ...others.map((name) => ({ value: `/${name}`, label: name, detail: docs[name] ?? "" })),
  ];
  const answer = await askChoice({ title: `Which ${lacks}?`, label: `The robot has no ${lacks} of its own`, options, search: true });
  if (answer === null) return false;
  await openSetup("grip.yaml");
  if (!answer.startsWith("/")) return (await freed(data)) && (await begin(answer));
  const both = { [has]: robot, [lacks]: answer.slice(1) };
  const [ofArm, ofHand] = (["arm", "hand"] as const).map((part) => Object.values(pairs).find((pair) => pair[part] === both[part])?.mount);
  await setValue(["robot"], { ...both, mount: { ...ofHand, link: ofArm?.link ?? tipOf(useRobot.getState().view) } });
  return (await freed(data)) && (await begin(""));
}

/** Worlds that are written for a robot that can't take anything yet. */
const BARE = ["table", "empty"];

/** What was written for the robot that lacked something makes room for what is written for the whole one; files stay. */
async function freed(data: unknown): Promise<boolean> {
  const bare = BARE.includes(String(valueAt(data, ["world"])));
  for (const part of ["arms", "hands", ...(bare ? ["world", "sensors"] : [])]) if (valueAt(data, [part]) !== undefined) await removeValue([part]);
  return saveSetup();
}

/** The link at an arm's end: the usual one, or what its last joint moves. */
function tipOf(view: GeometryView | null): string {
  const usual = ["tool0", "flange"].find((name) => view !== null && name in view.links);
  const last = Object.values(view?.groups ?? {}).sort((one, other) => other.length - one.length)[0]?.at(-1);
  return usual ?? view?.joints.find((joint) => joint.name === last)?.child ?? "tool0";
}

/** Back to the task, to the node for which something was made. */
export async function goOn(node: string): Promise<void> {
  const { wanted } = useBegin.getState();
  leaveBeginning();
  usePage.getState().setRoom("task");
  await wanted?.add(node);
  goToTree();
}

export function leaveBeginning(): void {
  useBegin.setState({ choosing: false, made: null, error: "", wanted: null });
}

export function chooseRobot(): void {
  useBegin.setState({ choosing: true, made: null, error: "", wanted: null });
  usePage.getState().setRoom("task");
}

// --- teaching: positions that a person keeps by moving the robot in the page, and a task that goes through them ---

const NAME = /^[A-Za-z_]\w*$/;

/** Write where a group of joints is into grip.yaml, as a named state; returns what came of it. */
export async function keepState(group: string, name: string, at: Readonly<Record<string, number>>): Promise<string> {
  if (!NAME.test(name)) return "A name has letters, digits and _, such as above_bin.";
  await openSetup("grip.yaml");
  const { view } = useSetup.getState();
  if (view?.path !== "grip.yaml") return "";
  const robot = valueAt(view.data, ["robot"]);
  if (typeof robot === "string") await setValue(["robot"], { [sourceOf(robot)]: robot });
  await setValue(["robot", "states", group, name], at);
  if (!(await saveSetup())) return "It couldn't be saved.";
  const { view: drawn } = useRobot.getState();
  if (drawn) useRobot.setState({ view: { ...drawn, states: { ...drawn.states, [group]: { ...drawn.states[group], [name]: at } } } });
  return `${name} is kept.`;
}

function sourceOf(robot: string): string {
  if (/\.(urdf|xacro)$/.test(robot)) return robot.endsWith("urdf") ? "urdf" : "xacro";
  return /[/.]/.test(robot) ? "moveit" : "ready";
}

type Parts = Readonly<Record<string, { readonly group?: string }>>;

/** Make a task of the named states that grip.yaml has, group by group in their order, and open it. */
export async function taskThrough(): Promise<void> {
  try {
    const { data } = await server.setupFile("grip.yaml");
    const children = (["arms", "hands"] as const).flatMap((kind) => {
      const parts = (valueAt(data, [kind]) ?? {}) as Parts;
      return Object.entries(parts).flatMap(([part, { group = kind === "arms" ? "arm" : "hand" }]) => {
        const states = Object.keys((valueAt(data, ["robot", "states", group]) ?? {}) as object);
        const node = kind === "arms" ? `arm/move_to, with: {arm: ${part}, state` : `hand/posture, with: {hand: ${part}, posture`;
        return states.map((state) => `    ${part}_${state}: {node: ${node}: ${state}}}\n`);
      });
    });
    if (children.length === 0) throw new Error("No position is kept yet: move the joints, name where they are, and keep it.");
    const taken = new Set(useProject.getState().project?.tasks.map((task) => task.path));
    let number = 1;
    while (taken.has(pathOf(number))) number++;
    const text = `grip: 1\nname: through${number === 1 ? "" : number}\ndoc: Go through the kept positions.\nroot:\n  kind: sequence\n  children:\n${children.join("")}`;
    await server.newTask({ path: pathOf(number), text });
    await refreshed();
    await openFirst(pathOf(number));
  } catch (error) {
    report(error);
  }
}

const pathOf = (number: number): string => `tasks/through${number === 1 ? "" : number}.yaml`;
