/** Every action by name and key: for the keyboard, the buttons, and the list of commands. */
import { findings } from "../model/commands";
import { kinds } from "../model/kinds";
import { allFolded } from "../model/visibility";
import { PAGE } from "../protocol/client";
import { askChoice, askText } from "./ask";
import { askConversion, extract, openSubtask } from "./converting";
import { callMe } from "./desk";
import { redo, save, undo } from "./editing";
import { connectOutcome, enterSelected, leaveContainer, toggleInPlace } from "./flowing";
import { addHere, changeKind, connectFree, copy, cut, duplicate, paste, remove, rename, shift, unwrap, wrap } from "./gestures";
import { goToPanel, usePage, type ViewName } from "./page";
import { type Pane, resetPanes, usePanes, widen } from "./panes";
import { LONGEST_NAME } from "./others";
import { useRun } from "./run";
import { useRunning } from "./runDesk";
import { injectFault, pauseOrResume, runFromHere, runToHere, start, step, stop, toggleBreakpoint } from "./running";
import { newTask } from "./tasks";

export interface Action {
  readonly id: string;
  readonly title: string;
  /** As `KeyboardEvent.key`, with modifiers before it. */
  readonly keys: readonly string[];
  /** Whether it also works while the focus is in a field. */
  readonly inFields?: boolean;
  /** Whether it asks something after it has looked at the server. */
  readonly asks?: boolean;
  readonly run: () => unknown;
}

const show = (view: ViewName) => (): void => usePage.getState().setView(view);

function toggleView(): void {
  const { view, setView } = usePage.getState();
  setView(view === "tree" ? "flow" : "tree");
}

function foldAll(): void {
  usePage.setState({ closed: allFolded(useRun.getState().task.nodes), opened: new Set() });
  usePage.getState().select("/");
}

/** In the outline and the tree; where the flow chart is shown, in place there too. */
function unfoldAll(): void {
  const { view, beside, opened } = usePage.getState();
  const flow = view === "flow" || (view === "split" && beside === "flow");
  usePage.setState({ closed: new Set(), opened: flow ? allFolded(useRun.getState().task.nodes) : opened });
}

const PANES: readonly (readonly [Pane, string])[] = [
  ["left", "outline and palette"],
  ["right", "the forms"],
  ["foot", "what is below the views"],
];

export const ACTIONS: readonly Action[] = [
  { id: "commands", title: "All commands", keys: ["Ctrl+k"], inFields: true, run: chooseAction },
  { id: "panel", title: "Go to the next panel", keys: ["F6"], inFields: true, run: () => goToPanel(1) },
  { id: "panel-before", title: "Go to the panel before", keys: ["Shift+F6"], inFields: true, run: () => goToPanel(-1) },
  { id: "find", title: "Search everything", keys: ["Ctrl+f"], run: find },
  { id: "save", title: "Save", keys: ["Ctrl+s"], inFields: true, run: () => save() },
  { id: "undo", title: "Undo", keys: ["Ctrl+z"], run: undo },
  { id: "redo", title: "Redo", keys: ["Ctrl+Shift+Z", "Ctrl+y"], run: redo },
  { id: "add", title: "Add a node here", keys: ["/"], run: addHere },
  { id: "rename", title: "Rename", keys: ["F2"], run: () => rename() },
  { id: "remove", title: "Delete", keys: ["Delete"], run: remove },
  { id: "copy", title: "Copy", keys: ["Ctrl+c"], run: copy },
  { id: "cut", title: "Cut", keys: ["Ctrl+x"], run: cut },
  { id: "paste", title: "Paste", keys: ["Ctrl+v"], run: () => paste() },
  { id: "duplicate", title: "Duplicate", keys: ["Ctrl+d"], run: duplicate },
  { id: "wrap", title: "Wrap in a container", keys: ["w"], run: () => wrap() },
  { id: "unwrap", title: "Unwrap", keys: ["Shift+W"], run: unwrap },
  { id: "kind", title: "Change kind", keys: ["k"], run: () => changeKind() },
  { id: "convert", title: "Convert to the other form", keys: ["Shift+K"], asks: true, run: () => askConversion() },
  { id: "extract", title: "Extract to a task of its own", keys: ["Shift+E"], asks: true, run: extract },
  { id: "open", title: "Open the subtask", keys: ["o"], run: () => openSubtask() },
  { id: "up", title: "Move up", keys: ["Alt+ArrowUp"], run: () => shift("up") },
  { id: "down", title: "Move down", keys: ["Alt+ArrowDown"], run: () => shift("down") },
  { id: "out", title: "Move out of the container", keys: ["Alt+ArrowLeft"], run: () => shift("out") },
  { id: "in", title: "Move into the container before", keys: ["Alt+ArrowRight"], run: () => shift("in") },
  { id: "connect", title: "Connect an outcome", keys: ["c"], run: () => connectOutcome() },
  { id: "free", title: "Connect free outcomes", keys: ["Shift+C"], run: () => connectFree() },
  { id: "toggle", title: "Tree or flow", keys: ["t"], run: toggleView },
  { id: "tree", title: "Show the tree", keys: ["Alt+1"], run: show("tree") },
  { id: "flow", title: "Show the flow chart", keys: ["Alt+2"], run: show("flow") },
  { id: "split", title: "Show tree and flow chart", keys: ["Alt+3"], run: show("split") },
  { id: "text", title: "Show the text", keys: ["Alt+4"], inFields: true, run: show("text") },
  { id: "robot", title: "Show the robot in 3D", keys: ["Alt+5"], inFields: true, run: show("robot") },
  { id: "left", title: "Show or hide outline and palette", keys: ["Ctrl+b"], inFields: true, run: () => usePanes.getState().toggle("left") },
  { id: "right", title: "Show or hide the forms", keys: ["Ctrl+Alt+b"], inFields: true, run: () => usePanes.getState().toggle("right") },
  { id: "foot", title: "Show or hide what is below the views", keys: ["Ctrl+j"], inFields: true, run: () => usePanes.getState().toggle("foot") },
  ...PANES.flatMap(([pane, title]) => [
    { id: `${pane}-more`, title: `More room for ${title}`, keys: [], run: () => widen(pane, 40) },
    { id: `${pane}-less`, title: `Less room for ${title}`, keys: [], run: () => widen(pane, -40) },
  ]),
  { id: "panes", title: "Panes as they were at first", keys: [], run: resetPanes },
  { id: "enter", title: "Go into the container", keys: ["Enter"], run: enterSelected },
  { id: "in-place", title: "Open the container in place, or close it", keys: ["Shift+Enter"], run: toggleInPlace },
  { id: "leave", title: "Go out of the container", keys: ["Backspace"], run: leaveContainer },
  { id: "unfold", title: "Unfold everything", keys: [], run: unfoldAll },
  { id: "fold", title: "Fold everything", keys: [], run: foldAll },
  { id: "run", title: "Run", keys: ["Alt+r"], inFields: true, run: () => start() },
  { id: "pause", title: "Pause or resume", keys: ["Alt+p"], inFields: true, run: pauseOrResume },
  { id: "stop", title: "STOP", keys: ["F8"], inFields: true, run: stop },
  { id: "breakpoint", title: "Set or clear a breakpoint", keys: ["F9"], inFields: true, run: () => toggleBreakpoint() },
  { id: "over", title: "Step over", keys: ["F10"], inFields: true, run: () => step("over") },
  { id: "into", title: "Step in", keys: ["F11"], inFields: true, run: () => step("in") },
  { id: "step-out", title: "Step out", keys: ["Shift+F11"], inFields: true, run: () => step("out") },
  { id: "tick", title: "Step by one tick", keys: ["Ctrl+F11"], inFields: true, run: () => step("tick") },
  { id: "from-here", title: "Run from here", keys: ["Ctrl+Enter"], run: runFromHere },
  { id: "to-here", title: "Run to here", keys: ["Ctrl+F10"], run: runToHere },
  { id: "fault", title: "Have something go wrong", keys: ["Ctrl+Alt+f"], inFields: true, run: injectFault },
  { id: "new", title: "New task", keys: [], run: newTask },
  { id: "name", title: "Change how others see you", keys: [], run: askForName },
];

export function actionTitle(id: string): string {
  const action = ACTIONS.find((each) => each.id === id);
  return action ? [action.title, keyText(action)].filter(Boolean).join(" · ") : id;
}

export function keyText(action: Action): string {
  return (action.keys[0] ?? "").replace("Arrow", "").replace(/\+([a-z])$/, (_, key: string) => `+${key.toUpperCase()}`);
}

/** The keys of an event in the words of `Action.keys`. */
export function keysOf(event: KeyboardEvent): string {
  const modifiers = [event.ctrlKey || event.metaKey ? "Ctrl" : "", event.altKey ? "Alt" : "", event.shiftKey && event.key !== "/" ? "Shift" : ""];
  return [...modifiers.filter(Boolean), event.key].join("+");
}

export function actionFor(event: KeyboardEvent): Action | undefined {
  const keys = keysOf(event);
  return ACTIONS.find((action) => action.keys.includes(keys));
}

async function chooseAction(): Promise<void> {
  const wraps = kinds().filter((face) => face.holds !== "none");
  const options = [
    ...ACTIONS.filter((action) => action.id !== "commands").map((action) => ({ value: action.id, label: action.title, mark: keyText(action) })),
    ...wraps.map((face) => ({ value: `wrap:${face.kind}`, label: `Wrap in ${face.title}` })),
  ];
  const id = await askChoice({ title: "Commands", label: "Type to find a command", options });
  if (id?.startsWith("wrap:")) await wrap(id.slice(5));
  else await ACTIONS.find((action) => action.id === id)?.run();
}

export async function find(): Promise<void> {
  const found = findings(useRun.getState().task);
  const path = await askChoice({ title: "Search", label: "Search names, values, variables, documentation", options: found, search: true });
  if (path !== null) usePage.getState().select(path.split("\n")[0] as string);
}

export async function askForName(): Promise<void> {
  const initial = useRunning.getState().desk.viewers.find((each) => each.page === PAGE)?.name ?? "";
  const check = (text: string): string => (text.trim() === "" ? "a name is needed" : text.trim().length > LONGEST_NAME ? `at most ${LONGEST_NAME} characters` : "");
  const name = await askText({ title: "Your name", label: "Shown to everyone who has the page open.", initial, check });
  if (name !== null) callMe(name);
}
