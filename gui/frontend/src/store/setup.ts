/** The settings file that is open: its text, which the page keeps, and what the server says about it. */
import { create } from "zustand";

import { RefusedError, server } from "../protocol/client";
import type { CommandResult, SetupEntry, SetupView } from "../protocol/generated";
import { askChoice } from "./ask";
import { useDocument } from "./document";
import { useRun } from "./run";
import { loadProject, renewNames } from "./tasks";

export type Making = "component" | "import" | "topics" | "messages" | null;

/** What of `grip.yaml` is shown: all of it, or how arms plan, or what sensors see. */
export type Part = "" | "motion" | "sensors";

export interface SetupStore {
  readonly part: Part;
  readonly files: readonly SetupEntry[];
  readonly view: SetupView | null;
  /** What the file holds on the disk, as far as we know. */
  readonly saved: string;
  readonly known: string;
  readonly busy: string;
  /** Whether what is said of the file is of an older text than is shown: the answer about this one is on its way. */
  readonly checking: boolean;
  readonly probe: CommandResult | null;
  /** What is being made instead of a file being shown. */
  readonly making: Making;
  /** The line that a problem is about, to be shown in the text. */
  readonly line: number | null;
}

export const useSetup = create<SetupStore>()(() => ({ part: "", files: [], view: null, saved: "", known: "", making: null, busy: "", checking: false, probe: null, line: null }));

/** Grows with every text; an answer about an older one is left out. */
let texts = 0;

export function report(error: unknown): void {
  useRun.getState().setError(error instanceof Error ? error.message : String(error));
}

export async function listSetup(): Promise<void> {
  useSetup.setState({ files: await server.setupFiles() });
}

export function isDirty(): boolean {
  const { view, saved } = useSetup.getState();
  return view !== null && view.text !== saved;
}

/** Grows with every file that is asked for; the answer about an older one is left out. */
let asked = 0;

/** Open a file; what isn't saved of another one is asked about, and of this one is kept. */
export async function openSetup(path: string): Promise<void> {
  await changes;
  await saving; // what is being saved needn't be asked about
  const { view } = useSetup.getState();
  if (view !== null && isDirty()) {
    if (view.path === path) return;
    const options = [
      { value: "save", label: `Save ${view.path}` },
      { value: "drop", label: "Discard the changes" },
    ];
    const answer = await askChoice({ title: `${view.path} isn't saved`, label: "Before opening another file", options });
    if (answer === null || (answer === "save" && !(await saveSetup()))) return;
  }
  const [text, turn] = [texts, ++asked];
  try {
    const opened = await server.setupFile(path);
    if (turn !== asked || text !== texts) return; // what was asked for or typed since counts
    texts++;
    useSetup.setState({ view: opened, saved: opened.text, known: opened.known, checking: false, probe: null, line: null });
  } catch (error) {
    report(error);
  }
}

async function looked(work: (view: SetupView) => Promise<SetupView>): Promise<void> {
  const { view } = useSetup.getState();
  if (view === null) return;
  const text = ++texts;
  useRun.getState().setError("");
  useSetup.setState({ checking: true });
  try {
    const next = await work(view);
    if (text === texts) useSetup.setState({ view: next });
  } catch (error) {
    report(error);
  } finally {
    if (text === texts) useSetup.setState({ checking: false });
  }
}

/** The person has typed. */
export function typeSetup(text: string): Promise<void> {
  const { view } = useSetup.getState();
  if (view !== null) useSetup.setState({ view: { ...view, text } });
  return looked((now) => server.setupCheck({ path: now.path, text }));
}

/** Changes of the form come one after the other: each is made in the text that the one before has left. */
let changes: Promise<void> = Promise.resolve();

function changed(work: (view: SetupView) => Promise<SetupView>): Promise<void> {
  const path = useSetup.getState().view?.path;
  changes = changes.then(() => (useSetup.getState().view?.path === path ? looked(work) : undefined));
  return changes;
}

type Place = (string | number)[];

/** Give what stands at a place a value. A place that depends on what is there, such as a free name, is found when its turn comes. */
export function setValue(key: Place | ((view: SetupView) => Place), value: unknown): Promise<void> {
  return changed((view) => server.setupChange({ path: view.path, text: view.text, do: "set", key: typeof key === "function" ? key(view) : key, value }));
}

export function removeValue(key: (string | number)[]): Promise<void> {
  return changed((view) => server.setupChange({ path: view.path, text: view.text, do: "remove", key, value: null }));
}

export function renameValue(key: (string | number)[], name: string): Promise<void> {
  return changed((view) => server.setupChange({ path: view.path, text: view.text, do: "rename", key, value: name }));
}

/** The answer to what was saved last. */
let saving: Promise<unknown> = Promise.resolve();

export async function saveSetup(over = false): Promise<boolean> {
  await changes;
  const { view, known } = useSetup.getState();
  if (view === null) return false;
  try {
    const request = server.setupSave({ path: view.path, text: view.text, known, over }).then((saved) => {
      useSetup.setState({ view: saved, saved: saved.text, known: saved.known });
    });
    saving = request.catch(() => undefined);
    await request;
    await refreshed();
    return true;
  } catch (error) {
    if (!(error instanceof RefusedError) || error.kind !== "disk") {
      report(error);
      return false;
    }
    const options = [
      { value: "over", label: "Overwrite the file", detail: "What was written there is lost" },
      { value: "theirs", label: "Reload the file", detail: "What was changed here is lost" },
    ];
    const answer = await askChoice({ title: `${view.path} was changed elsewhere`, label: "It was written since it was opened here", options });
    if (answer === "over") return saveSetup(true);
    if (answer === "theirs") {
      useSetup.setState({ saved: view.text });
      await openSetup(view.path);
    }
    return false;
  }
}

/** What the project offers may be more now: nodes of sensors and components, files. */
export async function refreshed(): Promise<void> {
  renewNames();
  await Promise.all([listSetup(), loadProject(), server.catalog().then(useDocument.getState().setCatalog)]);
}

export async function probe(what: "robot" | "generate" | "test"): Promise<void> {
  const { view } = useSetup.getState();
  if (view === null || (isDirty() && !(await saveSetup()))) return;
  useSetup.setState({ busy: what, probe: null });
  try {
    useSetup.setState({ probe: await server.setupProbe({ what, path: view.path, page: "" }) });
    await refreshed();
  } catch (error) {
    report(error);
  } finally {
    useSetup.setState({ busy: "" });
  }
}
