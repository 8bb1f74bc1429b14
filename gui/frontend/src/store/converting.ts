/** Conversion to the other form: looked at, and only then done, as one edit. */
import { type Command, nameOf } from "../model/commands";
import { hasEdges, kindTitle } from "../model/kinds";
import { server } from "../protocol/client";
import type { ConversionView, NodeView } from "../protocol/generated";
import { askChoice, askText } from "./ask";
import { chooseTask } from "./desk";
import { useDocument } from "./document";
import { edit } from "./editing";
import { type Above, usePage } from "./page";
import { useRun } from "./run";
import { loadProject, useProject } from "./tasks";

type Form = "tree" | "machine";

export async function askConversion(node = usePage.getState().selected ?? "/"): Promise<void> {
  const { document } = useDocument.getState();
  const view = useRun.getState().index.byPath.get(node);
  if (document === null || view === undefined) return;
  const chosen = await askForm(view.name, view.kind);
  if (chosen === null) return;
  const form: Form = chosen === "tree" ? "tree" : "machine";
  try {
    await decide(node, view.name, form, await server.conversion(document.path, node, form));
  } catch (error) {
    useRun.getState().setError(error instanceof Error ? error.message : String(error));
  }
}

/** What was found is shown; the person converts, or leaves it. */
async function decide(node: string, name: string, form: Form, found: ConversionView): Promise<void> {
  const answer = await askChoice({
    title: `${name} as a ${WORDS[form]}`,
    label: "What to do",
    lead: ["Both forms do the same.", ...found.kept.map((why) => `${why}.`)].join(" "),
    columns: [
      { title: `Now (${found.before.length} nodes)`, lines: found.before },
      { title: `Then (${found.after.length} nodes)`, lines: found.after },
    ],
    options: [
      { value: "yes", label: "Convert", detail: "One edit; undo restores the file exactly" },
      { value: "no", label: "Leave it as it is" },
    ],
  });
  if (answer === "yes") await edit({ do: "convert", path: node, to: form === "tree" ? "bt" : "sm" });
}

const WORDS: Record<Form, string> = { tree: "behaviour tree", machine: "state machine" };

async function askForm(name: string, kind: string): Promise<string | null> {
  const options = [
    { value: "tree", label: "To a behaviour tree", detail: "State machines in it become sequences, fallbacks and loops, where they have a structure" },
    { value: "machine", label: "To a state machine", detail: "Sequences, fallbacks and loops in it become states and edges" },
  ];
  if (!hasEdges({ kind })) options.reverse();
  return askChoice({ title: `Convert ${name} (${kindTitle(kind)})`, label: "Form", options });
}

const FILE = /^tasks\/[A-Za-z0-9_][A-Za-z0-9_ /-]*\.yaml$/;

function selectedNode(): NodeView | undefined {
  const { selected } = usePage.getState();
  return selected === null ? undefined : useRun.getState().index.byPath.get(selected);
}

/** The selected node with all below it goes to a file that the person names; a subtask takes its place. */
export async function extract(): Promise<void> {
  const node = selectedNode();
  if (node === undefined) return;
  if (node.path === "/") return useRun.getState().setError("The root is the task itself; wrap it, then extract the child.");
  const taken = new Set(useProject.getState().project?.tasks.map((task) => task.path));
  const check = (file: string): string => {
    if (!FILE.test(file)) return "A task file lies below tasks/ and ends with .yaml, such as tasks/fetch.yaml.";
    return taken.has(file) ? "A task with this name exists already." : "";
  };
  const hint = "Its inputs and outputs are the variables that this part reads and writes.";
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
      { value: "yes", label: `${title} anyway`, detail: "Values are copied in at the start and out at the end; undo restores it" },
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
