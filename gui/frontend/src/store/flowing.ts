/** What is done in a flow chart: connect, disconnect, begin elsewhere, go in and out. What could mean two things is asked. */
import { type Command, group, join, nameOf, parentOf, wrapping } from "../model/commands";
import { hasEdges, kindTitle } from "../model/kinds";
import type { NodeView } from "../protocol/generated";
import { askChoice, type Option } from "./ask";
import { useDocument } from "./document";
import { edit } from "./editing";
import { withEdges } from "./gestures";
import { usePage } from "./page";
import { useRun } from "./run";
import { goUp, openSubtask } from "./converting";

const nodes = (): ReadonlyMap<string, NodeView> => useRun.getState().index.byPath;

/** Where the outcomes of a node may lead: siblings in a state machine, and the outcomes of what is around it. */
function targets(path: string): Option[] {
  const parent = parentOf(path);
  const node = parent === null ? undefined : nodes().get(parent);
  if (node === undefined) return Object.keys(useRun.getState().task.outcomes).map((end) => ({ value: end, label: end, mark: "ends the task" }));
  const siblings = node.children.map((child) => ({ value: nameOf(child), label: nameOf(child), mark: "sibling" }));
  return [...siblings, ...Object.entries(node.outcomes).map(([end, meaning]) => ({ value: end, label: end, mark: `ends ${node.name}: ${meaning}` }))];
}

/** Connect from the keyboard: which outcome, then where to. */
export async function connectOutcome(path = usePage.getState().selected, outcome?: string): Promise<void> {
  const node = path === null ? undefined : nodes().get(path);
  if (path === null || node === undefined) return;
  const led = new Map(node.on.map((edge) => [edge.outcome, edge.target]));
  const codes = useDocument.getState().catalog.nodes.find((face) => face.id === node.label)?.codes ?? [];
  const labels = [...Object.keys(node.outcomes), ...(node.outcomes["failure"] ? codes.map((code) => `failure.${code}`) : [])];
  const options = labels.map((each) => ({ value: each, label: each, mark: led.has(each) ? `leads to ${led.get(each)}` : "free" }));
  const from = outcome ?? (await askChoice({ title: `Which outcome of ${node.name}?`, label: "Outcome", options }));
  if (from === null) return;
  const to = await askChoice({ title: `${node.name}.${from} leads to`, label: "Target", options: targets(path) });
  if (to !== null) await connect(path, from, to);
}

/** Lead an outcome somewhere. Between siblings outside a state machine there is no edge: the person says what is meant. */
export async function connect(path: string, outcome: string, target: string): Promise<void> {
  const parent = parentOf(path);
  const around = parent === null ? undefined : nodes().get(parent);
  const toSibling = around !== undefined && around.children.includes(join(around.path, target));
  if (!toSibling || hasEdges(around)) {
    await edit({ do: "connect", path, outcome, target }, path, `${nameOf(path)}.${outcome} leads to ${target}`);
    return;
  }
  const ways = lastFirst(meanings(around, path, outcome, target));
  const way = await askChoice({
    title: `${nameOf(path)}.${outcome} to ${target}?`,
    label: "Choose what this edge means",
    lead: `${around.name} is a ${kindTitle(around.kind)}: its order decides, and there are no edges between its children.`,
    options: ways,
  });
  const command = ways.find((each) => each.value === way)?.command;
  if (way) localStorage.setItem(LAST_WAY, way);
  if (command) await edit(command, undefined, "done as chosen");
}

const LAST_WAY = "grip.last-way";

/** What was chosen last time comes first, where it is offered again. */
function lastFirst(ways: Way[]): Way[] {
  const last = localStorage.getItem(LAST_WAY);
  const again = ways.filter((way) => way.value === last).map((way) => ({ ...way, mark: "as last time" }));
  return [...again, ...ways.filter((way) => way.value !== last)];
}

interface Way extends Option {
  readonly command: Command;
}

/** What an edge between two children of a composite can mean, as commands. */
function meanings(around: NodeView, path: string, outcome: string, target: string): Way[] {
  const ways: Way[] = [];
  const at = around.children.indexOf(path);
  const to = join(around.path, target);
  const failed = nodes().get(path)?.outcomes[outcome.split(".")[0] as string] === "failure";
  const kind = failed ? "fallback" : "sequence";
  if (around.children[at + 1] === to && around.kind !== kind) {
    const { command } = wrapping(nodes(), [path, to], kind);
    ways.push({ value: kind, label: `${kindTitle(kind)}(${nameOf(path)}, ${target})`, detail: `${target} runs when ${nameOf(path)} ends with ${failed ? "failure" : "success"}; both become one step of ${around.name}`, command });
  }
  if (to === path) {
    const kind = failed ? "retry" : "repeat";
    const { command } = wrapping(nodes(), [path], kind);
    ways.push({ value: kind, label: `${kindTitle(kind)}(${nameOf(path)})`, detail: `${nameOf(path)} runs again when it ends with ${failed ? "failure" : "success"}, as often as the ${kind} says`, command });
  }
  const connected = group(`${around.name} as a state machine`, [...withEdges(around), { do: "connect", path, outcome, target }]);
  ways.push({ value: "machine", label: `Make ${around.name} a state machine`, detail: `The order of its ${around.children.length} children becomes edges, and ${outcome} leads to ${target}`, command: connected });
  return ways;
}

/** Take an edge out. A derived one comes from the order, so that it can't go alone. */
export async function disconnect(path: string, outcome: string, derived: boolean): Promise<void> {
  if (!derived) {
    await edit({ do: "disconnect", path, outcome }, path, `${nameOf(path)}.${outcome} leads nowhere now`);
    return;
  }
  const around = nodes().get(parentOf(path) ?? "/");
  if (around === undefined) return;
  const answer = await askChoice({
    title: "This edge follows from the order of the children",
    label: "What to do",
    lead: `${around.name} is a ${kindTitle(around.kind)}; only the edges of a state machine can be removed one by one.`,
    options: [{ value: "machine", label: `Make ${around.name} a state machine`, detail: "Its order becomes edges, which can be changed" }],
  });
  if (answer) await edit(group(`${around.name} as a state machine`, withEdges(around)));
}

export async function beginWith(path: string): Promise<void> {
  const parent = parentOf(path);
  if (parent !== null) await edit({ do: "set", path: parent, key: ["initial"], value: nameOf(path) }, path, `${parent} begins with ${nameOf(path)}`);
}

export function enterSelected(): void {
  const { selected, enter, setView, view } = usePage.getState();
  const node = selected === null ? undefined : nodes().get(selected);
  if (node?.kind === "subtask") return openSubtask(node);
  if (node === undefined || node.children.length === 0) return;
  enter(node.path);
  if (view === "tree") setView("flow");
}

/** Show the inside of the selected container within the chart, or close it. */
export function toggleInPlace(): void {
  const { selected, opened, openInPlace } = usePage.getState();
  const node = selected === null ? undefined : nodes().get(selected);
  if (node !== undefined && node.children.length > 0 && node.path !== "/") openInPlace(node.path, !opened.has(node.path));
}

export function leaveContainer(): void {
  const { container, enter, select } = usePage.getState();
  const parent = parentOf(container);
  if (parent === null) return void goUp();
  select(container);
  enter(parent);
}
