/** A part of a task as a file of its own, back again, and the way into such a file and out of it. */
import { type Command, nameOf } from "../model/commands";
import { server } from "../protocol/client";
import type { NodeView } from "../protocol/generated";
import { askChoice, askText } from "./ask";
import { chooseTask } from "./desk";
import { useDocument } from "./document";
import { edit } from "./editing";
import { type Above, usePage } from "./page";
import { useRun } from "./run";
import { loadProject, useProject } from "./tasks";

const FILE = /^tasks\/[A-Za-z0-9_][A-Za-z0-9_ /-]*\.yaml$/;

function selectedNode(): NodeView | undefined {
  const { selected } = usePage.getState();
  return selected === null ? undefined : useRun.getState().index.byPath.get(selected);
}

/** The selected node with all below it goes to a file that the person names; a subtask takes its place. */
export async function extract(): Promise<void> {
  const node = selectedNode();
  if (node === undefined) return;
  if (node.path === "/") return useRun.getState().setTrouble("The root is the task already; wrap it, and extract the child.");
  const taken = new Set(useProject.getState().project?.tasks.map((task) => task.path));
  const check = (file: string): string => {
    if (!FILE.test(file)) return "A task file lies below tasks/ and ends with .yaml, such as tasks/fetch.yaml.";
    return taken.has(file) ? "A task of this name is there." : "";
  };
  const hint = "Its inputs and outputs follow from the variables that the part reads and writes.";
  const file = await askText({ title: `Extract ${node.name} to a task of its own`, label: "File", initial: freshFile(node.name, taken), hint, check });
  if (file === null) return;
  await handingOver({ do: "extract", path: node.path, file }, `Extract ${node.name}`, node.path, `${node.name} is a subtask now, in ${file}`);
}

function freshFile(name: string, taken: ReadonlySet<string>): string {
  const base = name.replace(/[^A-Za-z0-9_-]+/g, "_");
  for (let n = 1; ; n++) {
    const file = `tasks/${base}${n === 1 ? "" : `_${n}`}.yaml`;
    if (!taken.has(file)) return file;
  }
}

/** What is in the selected subtask's file takes the subtask's place; the file stays. */
export async function inline(): Promise<void> {
  const node = selectedNode();
  if (node?.kind !== "subtask") return useRun.getState().setTrouble("Select a subtask: its file's inside takes its place.");
  await handingOver({ do: "inline", path: node.path }, `Inline ${node.name}`, node.path, `the inside of ${node.label} is here now`);
}

/** Where it would make a difference, the person says whether it is done all the same. */
async function handingOver(command: Command, title: string, select: string, said: string): Promise<void> {
  let why = "";
  let done = await edit(command, select, said, (kind, message) => {
    if (kind === "approximate") why = message;
    return kind === "approximate";
  });
  if (why !== "") {
    const options = [
      { value: "no", label: "Leave it as it is" },
      { value: "yes", label: `${title} all the same`, detail: "Values go in when it starts and out when it ends; undo takes it back" },
    ];
    if ((await askChoice({ title: `${title}?`, label: "What to do", lead: why, options })) !== "yes") return;
    done = await edit({ ...command, approximate: true }, select, said);
  }
  if (done) await Promise.all([loadProject(), server.catalog().then(useDocument.getState().setCatalog)]);
}

/** Show the task that a subtask runs; the way back stays on the page. */
export function openSubtask(node = selectedNode()): void {
  if (node?.kind !== "subtask") return;
  const { task } = useRun.getState();
  void chooseTask(node.label, [...usePage.getState().trail, { task: task.path, name: task.name, node: node.path }]);
}

/** Go back to a task of the trail, to the subtask through which it was left. */
export async function goUp(at = usePage.getState().trail.length - 1): Promise<void> {
  const { trail } = usePage.getState();
  const above: Above | undefined = trail[at];
  if (above === undefined) return;
  await chooseTask(above.task, trail.slice(0, at));
  if (useRun.getState().index.byPath.has(above.node)) usePage.getState().select(above.node);
  useDocument.getState().say(`back in ${above.name}, at ${nameOf(above.node)}`);
}
