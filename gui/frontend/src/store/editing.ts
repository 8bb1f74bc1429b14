/** What edits do: each goes to the server, one after the other, and its answer is the new state. */
import type { Command } from "../model/commands";
import { sharing, whereNow } from "../model/history";
import { GoneError, RefusedError, server } from "../protocol/client";
import type { DocumentView, PinRequest } from "../protocol/generated";
import { type Conflict, useDocument } from "./document";
import { usePage } from "./page";
import { useRun } from "./run";

const CONFLICTS = new Set(["stale", "disk", "unfinished"]);
/** Tasks of more nodes are checked only when the person pauses. */
const LARGE = 1000;
/** Wishes are sent one at a time, so that each is made on the newest revision. */
let queue: Promise<unknown> = Promise.resolve();

/** Whether what is shown can be edited: a task file, not the record of a run. */
export function editable(): boolean {
  return useRun.getState().record === null && useDocument.getState().document !== null;
}

/**
 * Take what the server sent; an older document than that which is shown comes too late.
 * @param from who has changed it: this page, another one, or a server that was started again and counts anew.
 */
export function take(answer: DocumentView, from: "here" | "elsewhere" | "anew" = "here"): void {
  const { document, setDocument } = useDocument.getState();
  if (from !== "anew" && document?.path === answer.path && answer.revision < document.revision) return;
  const view = document?.path === answer.path ? { ...answer, task: sharing(answer.task, document.task, answer.checked) } : answer;
  setDocument(view);
  const { record, task, showTask } = useRun.getState();
  if (record !== null) return;
  if (task !== view.task) showTask(view.task);
  const before = usePage.getState().selected;
  keepSelection(answer.moved);
  const now = usePage.getState().selected;
  // Who works at a node learns that it went, and that the forms are about another one.
  if (from === "elsewhere" && before !== null && before !== now && whereNow(before, useRun.getState().index.byPath, answer.moved) !== now) {
    useRun.getState().setError(`${before} was removed elsewhere; ${now === "/" ? "the root" : now} is selected now.`);
  }
  if (!view.checked) loadProblems();
  loadForms();
}

/** Selection and place of a task whose nodes have changed: they follow what was moved; what is gone gives way to what is above it. */
function keepSelection(moved: Readonly<Record<string, string>>): void {
  const known = useRun.getState().index.byPath;
  const { selected, marked, container, closed, opened } = usePage.getState();
  const near = (path: string): string => {
    let at = whereNow(path, known, moved);
    while (at !== "/" && !known.has(at)) at = at.includes("/") ? at.slice(0, at.lastIndexOf("/")) : "/";
    return at;
  };
  const followed = (paths: ReadonlySet<string>): Set<string> => new Set([...paths].map((path) => whereNow(path, known, moved)));
  const gone = (paths: ReadonlySet<string>): boolean => [...paths].some((path) => !known.has(path));
  if (selected !== null && gone(marked)) {
    const there = [...followed(marked)].filter((path) => known.has(path));
    usePage.setState({ selected: near(selected), marked: new Set([...there, near(selected)]) });
  }
  if (!known.has(container)) usePage.setState({ container: near(container) });
  if (Object.keys(moved).length === 0) return;
  if (gone(closed)) usePage.setState({ closed: followed(closed) });
  if (gone(opened)) usePage.setState({ opened: followed(opened) });
}

/** What takes a refusal over, so that it isn't told as error; false where it doesn't. */
type Refused = (kind: string, message: string) => boolean;

/** A setting of a node as it is now: what a change of it has to start from. */
export function settingNow(path: string, key: string): unknown {
  return useRun.getState().index.byPath.get(path)?.fields[key];
}

/** Makes a request on a document; `again` when the server had gone before it could be taken. */
type Request = (document: DocumentView, again: boolean) => Promise<DocumentView> | null;

/** Send a request when its turn comes; one that finds nothing to request for any more (null) is left out. */
function send(request: Request, text?: string, taken: Refused = () => false): Promise<boolean> {
  const attempt = async (again: boolean): Promise<boolean> => {
    const { document } = useDocument.getState();
    if (document === null) return false;
    useDocument.getState().setConflict(null);
    useRun.getState().setError("");
    try {
      const answer = request(document, again);
      if (answer === null) return false;
      take(await answer);
      return true;
    } catch (error) {
      if (error instanceof GoneError) return (await isSame(document)) ? attempt(true) : false;
      if (!(error instanceof RefusedError) || !taken(error.kind, error.message)) await refused(document.path, error, text);
      return false;
    }
  };
  const sent = queue.then(() => attempt(false));
  queue = sent;
  return sent;
}

let waiters: (() => void)[] = [];

/** Wait until the server answers again. Whether the file is then what it was: what was sent last may have come through, and isn't done twice. */
async function isSame(before: DocumentView): Promise<boolean> {
  useDocument.setState(({ waiting }) => ({ waiting: waiting + 1 }));
  await new Promise<void>((resolve) => waiters.push(resolve));
  useDocument.setState(({ waiting }) => ({ waiting: waiting - 1 }));
  const { document } = useDocument.getState();
  if (document?.path === before.path && document.text === before.text) return true;
  useRun.getState().setError("The server went away during an edit, and the file is another one now: look whether the edit is in it.");
  return false;
}

/** Look at everything anew, then send what has waited. */
export async function serverIsBack(): Promise<void> {
  const { document } = useDocument.getState();
  try {
    if (document !== null) take(await server.document(document.path), "anew");
    useRun.getState().setError("");
  } catch (error) {
    if (error instanceof GoneError) return; // the next connection comes here again
    useRun.getState().setError(error instanceof Error ? error.message : String(error));
  }
  const released = waiters;
  waiters = [];
  for (const release of released) release();
}

async function refused(path: string, error: unknown, text?: string): Promise<void> {
  const message = error instanceof Error ? error.message : String(error);
  if (error instanceof RefusedError && CONFLICTS.has(error.kind)) {
    const conflict: Conflict = text === undefined ? { kind: error.kind, message } : { kind: error.kind, message, text };
    useDocument.getState().setConflict(conflict);
    take(await server.document(path));
  } else useRun.getState().setError(message);
}

/** Carry out a command; afterwards these nodes are selected. One that depends on how things are is made when its turn comes. */
export async function edit(command: Command | (() => Command), select?: string | readonly string[], said?: string, taken?: Refused): Promise<boolean> {
  if (!editable()) {
    useRun.getState().setError("This is the record of a run; go back to the task to edit it.");
    return false;
  }
  const { picks } = usePage.getState();
  const done = await send(
    ({ path, revision }) => server.edit({ path, base: revision, command: typeof command === "function" ? command() : command }, revision),
    undefined,
    taken,
  );
  // Who has turned to another node meanwhile stays there.
  if (done && select !== undefined && usePage.getState().picks === picks) {
    const known = useRun.getState().index.byPath;
    const paths = (typeof select === "string" ? [select] : select).filter((path) => known.has(path));
    if (paths.length > 0) usePage.getState().settle(paths);
  }
  if (done && said) useDocument.getState().say(said);
  return done;
}

function step(what: "undo" | "redo" | "go", number: number | null = null): Promise<boolean> {
  return send(({ path, revision, history }) => {
    // Who presses faster than the answers come has come to the end meanwhile.
    if ((what === "undo" && !history.can_undo) || (what === "redo" && number === null && !history.can_redo)) return null;
    return server.step({ path, base: revision, step: what, number }, revision);
  });
}

export const undo = (): Promise<boolean> => step("undo");
export const redo = (): Promise<boolean> => step("redo");
export const goTo = (number: number): Promise<boolean> => step("go", number);

/** Take a text that was typed on the revision `base`; null puts it over whatever is there. */
export function typeText(text: string, base: number | null): Promise<boolean> {
  return send(({ path, revision }, again) => server.text({ path, base: again ? revision : (base ?? revision), text, over: base === null }, revision), text);
}

export function pin(view: PinRequest["view"], positions: Record<string, [number, number] | null>): Promise<boolean> {
  return send(({ path, revision }) => server.pin({ path, view, positions }, revision));
}

let typed: (() => Promise<unknown>) | null = null;

/** Say how to send what is being typed in the text view; null when that is closed. */
export function typing(flush: (() => Promise<unknown>) | null): void {
  typed = flush;
}

/** What is typed goes first: it is what the person sees. */
export const settled = async (): Promise<unknown> => typed?.();

export async function save(over = false): Promise<boolean> {
  await settled();
  return send(({ path, revision }) => server.save({ path, over }, revision));
}

export function takeFromDisk(): Promise<boolean> {
  return send(({ path, revision }) => server.disk({ path }, revision));
}

/** Ask for the newest state where the server has told of one. */
export function heardOfRevisions(revisions: Record<string, number>): void {
  void queue.then(async () => {
    const { document } = useDocument.getState();
    if (document === null || (revisions[document.path] ?? 0) <= document.revision) return;
    take(await server.document(document.path, document.revision), "elsewhere");
  });
}

/** Ask for something about the newest state, once nothing has changed for a while [ms]. */
function afterwards<T extends { readonly revision: number }>(pause: () => number, find: (path: string) => Promise<T>, put: (found: T) => void): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  return () => {
    clearTimeout(timer);
    timer = setTimeout(async () => {
      const path = useDocument.getState().document?.path;
      if (path === undefined) return;
      const found = await find(path).catch(() => null);
      const now = useDocument.getState().document;
      if (found && now?.path === path && now.revision === found.revision) put(found);
    }, pause());
  };
}

/** Which containers both forms edit; long to find in a large task, so that the next edit isn't kept waiting for it. */
const loadForms = afterwards(() => (useRun.getState().task.nodes.length > LARGE ? 1500 : 250), server.forms, (found) => useDocument.getState().setForms(found));

const loadProblems = afterwards(() => (useRun.getState().task.nodes.length > LARGE ? 400 : 60), server.problems, ({ problems }) => {
  const { document, setDocument } = useDocument.getState();
  const { record, setProblems } = useRun.getState();
  if (document === null) return;
  const task = { ...document.task, problems };
  setDocument({ ...document, task, checked: true });
  if (record === null) setProblems(task);
});
