/** What the buttons do, and what the socket brings: the one place that joins server and stores. */
import { foldedAtFirst } from "../model/visibility";
import { server, Socket } from "../protocol/client";
import type { RunRecord, ServerFrame } from "../protocol/generated";
import { useDocument } from "./document";
import { heardOfRevisions, serverIsBack, take } from "./editing";
import { givenName, keepName, lookedAt, ownSelection, tellSelection, useOthers } from "./others";
import { type Above, usePage } from "./page";
import { useRun } from "./run";
import { useRunning } from "./runDesk";

let socket: Socket | null = null;
/** Grows with every request to show something; an answer to an older request comes too late and is left out. */
let requests = 0;
/** Whether the person has chosen what to look at: then the last run, that ended before the page came, stays behind. */
let chosen = false;
/** Whether the server has told of its last run. */
let greeted = false;

export function connect(): () => void {
  socket = new Socket({
    frame: heard,
    connected: (yes, stranger) => {
      const { connected, setConnected } = useRun.getState();
      setConnected(yes, stranger);
      if (yes && connected === false) void serverIsBack();
      // Everybody is told of anew by the next connection.
      useOthers.getState().forget();
    },
    introduction: () => ({ type: "introduce", name: givenName(), task: lookedAt() }),
    selection: ownSelection,
    request: () => {
      const { record, history } = useRun.getState();
      const run = record?.id;
      return run !== undefined ? { type: "subscribe", run, from_seq: history.nextSeq } : null;
    },
  });
  const tell = (): void => {
    if (told === lookedAt()) return;
    told = lookedAt();
    socket?.introduce();
  };
  let told = lookedAt();
  const ends = [useRun.subscribe(tell), usePage.subscribe(tell), tellSelection((selection) => socket?.select(selection))];
  return () => {
    for (const end of ends) end();
    socket?.close();
  };
}

/** Be called so on all pages, also after a reload and in new tabs. */
export function callMe(name: string): void {
  keepName(name);
  socket?.introduce();
}

function heard(frame: ServerFrame): void {
  const run = useRun.getState();
  switch (frame.type) {
    case "session": {
      const known = run.session?.run;
      run.setSession(frame.session);
      const id = frame.session?.run;
      // A run that has just begun, here or on another page, is what everybody wants to see.
      const isNews = greeted || !chosen || frame.session?.state !== "ended";
      greeted = true;
      const held = frame.session?.held?.path;
      // Who edits the task meanwhile isn't called away from it.
      const looks = run.record !== null || id !== known;
      if (held !== undefined && looks && usePage.getState().follow) usePage.getState().select(held);
      if (id && id !== known && id !== run.record?.id && isNews) void openRun(id);
      break;
    }
    case "desk":
      useRunning.getState().setDesk(frame.desk);
      break;
    case "selections":
      useOthers.getState().hear(frame.selections);
      break;
    case "events":
      run.addEvents(frame.run, frame.events, frame.complete);
      break;
    case "revisions":
      heardOfRevisions(frame.revisions);
      break;
    case "refused":
      run.setError(`The server refused a message: ${frame.reason}`);
      break;
  }
}

/** Run something that asks the server; what goes wrong is shown, not thrown. */
export async function trying(work: () => Promise<void>): Promise<void> {
  useRun.getState().setError("");
  try {
    await work();
  } catch (error) {
    useRun.getState().setError(error instanceof Error ? error.message : String(error));
  }
}

/** Show a task that a person picked, alone or through the subtasks of others. */
export async function chooseTask(path: string, trail: readonly Above[] = []): Promise<void> {
  chosen = true;
  await openTask(path);
  if (useRun.getState().task.path === path) usePage.setState({ trail });
}

/** Show a run that a person picked. */
export function chooseRun(id: string): Promise<void> {
  chosen = true;
  return openRun(id);
}

/** Show a task, with this node selected; the root by default. */
export function openTask(path: string, node?: string): Promise<void> {
  const request = ++requests;
  return trying(async () => {
    const document = await server.document(path);
    if (request !== requests) return;
    useDocument.getState().setConflict(null);
    usePage.setState({ closed: foldedAtFirst(document.task.nodes), opened: new Set() });
    useRun.getState().showTask(document.task);
    take(document);
    usePage.getState().enter("/");
    const known = useRun.getState().index.byPath;
    usePage.getState().select(node !== undefined && known.has(node) ? node : (document.task.nodes[0]?.path ?? null));
  });
}

function openRun(id: string): Promise<void> {
  const request = ++requests;
  return trying(async () => {
    const view = await server.run(id);
    if (request !== requests) return;
    useRun.getState().showTask(view.task, view.run);
    usePage.getState().setFoot("run");
    socket?.subscribe();
  });
}

export async function listRuns(): Promise<RunRecord[]> {
  let runs: RunRecord[] = [];
  await trying(async () => {
    runs = await server.runs();
  });
  return runs;
}
