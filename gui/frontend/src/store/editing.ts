/** What edits do: each goes to the server, one after the other, and its answer is the new state. */
import type { Command } from "../model/commands";
import { RefusedError, server } from "../protocol/client";
import type { DocumentView, PinWish } from "../protocol/generated";
import { type Conflict, useDocument } from "./document";
import { usePage } from "./page";
import { useRun } from "./run";

const CONFLICTS = new Set(["stale", "disk", "unfinished"]);
/** Wishes are sent one at a time, so that each is made on the newest revision. */
let queue: Promise<unknown> = Promise.resolve();

/** Whether what is shown can be edited: a task file, not the record of a run. */
export function editable(): boolean {
  return useRun.getState().record === null && useDocument.getState().document !== null;
}

/** Take a document that the server sent; an older one than that which is shown comes too late. */
export function take(view: DocumentView): void {
  const { document, setDocument } = useDocument.getState();
  if (document?.path === view.path && view.revision < document.revision) return;
  setDocument(view);
  const { record, task, showTask } = useRun.getState();
  if (record !== null) return;
  if (task.path !== view.path || JSON.stringify(task) !== JSON.stringify(view.task)) showTask(view.task);
  keepSelection();
  void loadForms();
}

/** Selection and place of a task whose nodes have changed: what is gone gives way to what is above it. */
function keepSelection(): void {
  const known = useRun.getState().index.byPath;
  const { selected, marked, container } = usePage.getState();
  const near = (path: string): string => {
    let at = path;
    while (at !== "/" && !known.has(at)) at = at.includes("/") ? at.slice(0, at.lastIndexOf("/")) : "/";
    return at;
  };
  if (selected !== null && !known.has(selected)) usePage.setState({ selected: near(selected), marked: new Set([near(selected)]) });
  else if ([...marked].some((path) => !known.has(path))) usePage.setState({ marked: new Set([...marked].filter((path) => known.has(path))) });
  if (!known.has(container)) usePage.setState({ container: near(container) });
}

function send(wish: (document: DocumentView) => Promise<DocumentView>, text?: string): Promise<boolean> {
  const sent = queue.then(async () => {
    const { document } = useDocument.getState();
    if (document === null) return false;
    useDocument.getState().setConflict(null);
    useRun.getState().setTrouble("");
    try {
      take(await wish(document));
      return true;
    } catch (error) {
      await refused(document.path, error, text);
      return false;
    }
  });
  queue = sent;
  return sent;
}

async function refused(path: string, error: unknown, text?: string): Promise<void> {
  const message = error instanceof Error ? error.message : String(error);
  if (error instanceof RefusedError && CONFLICTS.has(error.kind)) {
    const conflict: Conflict = text === undefined ? { kind: error.kind, message } : { kind: error.kind, message, text };
    useDocument.getState().setConflict(conflict);
    take(await server.document(path));
  } else useRun.getState().setTrouble(message);
}

/** Carry out a command; afterwards these nodes are selected. */
export async function edit(command: Command, select?: string | readonly string[], said?: string): Promise<boolean> {
  if (!editable()) {
    useRun.getState().setTrouble("What is shown is the record of a run; go back to the task to edit it.");
    return false;
  }
  const before = usePage.getState().selected;
  const done = await send(({ path, revision }) => server.edit({ path, base: revision, command }));
  // Who has turned to another node meanwhile stays there.
  const stayed = usePage.getState().selected === before || !useRun.getState().index.byPath.has(before ?? "");
  if (done && select !== undefined && stayed) {
    const known = useRun.getState().index.byPath;
    const paths = (typeof select === "string" ? [select] : select).filter((path) => known.has(path));
    if (paths.length > 0) usePage.getState().markAll(paths);
  }
  if (done && said) useDocument.getState().say(said);
  return done;
}

function step(what: "undo" | "redo" | "go", number: number | null = null): Promise<boolean> {
  return send(({ path, revision }) => server.step({ path, base: revision, step: what, number }));
}

export const undo = (): Promise<boolean> => step("undo");
export const redo = (): Promise<boolean> => step("redo");
export const goTo = (number: number): Promise<boolean> => step("go", number);

/** Take a text that was typed on the revision `base`; null puts it over whatever is there. */
export function typeText(text: string, base: number | null): Promise<boolean> {
  return send(({ path, revision }) => server.text({ path, base: base ?? revision, text, over: base === null }), text);
}

export function pin(view: PinWish["view"], positions: Record<string, [number, number] | null>): Promise<boolean> {
  return send(({ path }) => server.pin({ path, view, positions }));
}

export function convert(node: string, form: "tree" | "machine"): Promise<boolean> {
  return send(({ path, revision }) => server.convert({ path, base: revision, node, form }));
}

export function save(over = false): Promise<boolean> {
  return send(({ path }) => server.save({ path, over }));
}

export function takeFromDisk(): Promise<boolean> {
  return send(({ path }) => server.disk({ path }));
}

/** Ask for the newest state where the server has told of one. */
export function heardOfRevisions(revisions: Record<string, number>): void {
  void queue.then(async () => {
    const { document } = useDocument.getState();
    if (document === null || (revisions[document.path] ?? 0) <= document.revision) return;
    take(await server.document(document.path));
  });
}

let formsTimer: ReturnType<typeof setTimeout> | undefined;

/** Ask which containers both forms edit, once nothing has changed for a while. */
function loadForms(): void {
  clearTimeout(formsTimer);
  formsTimer = setTimeout(async () => {
    const path = useDocument.getState().document?.path;
    if (path === undefined) return;
    const forms = await server.forms(path).catch(() => null);
    const now = useDocument.getState().document;
    if (forms && now?.path === path && now.revision === forms.revision) useDocument.getState().setForms(forms);
  }, 250);
}
