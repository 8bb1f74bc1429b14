/** Task files of the project: the list, and new ones. */
import { create } from "zustand";

import { setKinds } from "../model/kinds";
import { optionsAt } from "../model/shapes";
import { server } from "../protocol/client";
import type { ProjectView } from "../protocol/generated";
import { askText } from "./ask";
import { chooseTask } from "./desk";
import { useDocument } from "./document";
import { goToTree } from "./page";
import { useRun } from "./run";

export const useProject = create<{ readonly project: ProjectView | null }>()(() => ({ project: null }));

export async function loadProject(): Promise<ProjectView> {
  const project = await server.project();
  setKinds(project.kinds);
  useProject.setState({ project });
  return project;
}

export async function newTask(): Promise<void> {
  const taken = new Set(useProject.getState().project?.tasks.map((task) => task.path));
  const check = (name: string): string => {
    if (!/^[A-Za-z_][A-Za-z0-9_ /-]*$/.test(name)) return "Use letters, digits, _, - and spaces; / makes a folder.";
    return taken.has(`tasks/${name}.yaml`) ? "A task with this name exists already." : "";
  };
  const name = await askText({ title: "New task", label: "Name", initial: "", hint: "It becomes tasks/<name>.yaml", check });
  if (name === null) return;
  try {
    await server.newTask({ path: `tasks/${name}.yaml`, text: null });
    await Promise.all([loadProject(), server.catalog().then(useDocument.getState().setCatalog)]);
    await chooseTask(`tasks/${name}.yaml`);
    goToTree();
  } catch (error) {
    useRun.getState().setError(error instanceof Error ? error.message : String(error));
  }
}

interface Names {
  readonly places: Readonly<Record<string, readonly string[]>>;
  readonly asked: boolean;
}

export const useNames = create<Names>()(() => ({ places: {}, asked: false }));

/** Ask, unless that was done; without an answer nothing is offered. */
export function needNames(): void {
  if (useNames.getState().asked) return;
  useNames.setState({ asked: true });
  loadNames();
}

/** The files are others now. */
export function renewNames(): void {
  if (useNames.getState().asked) loadNames();
}

/** What may stand in a parameter of a node; undefined where nothing is known. */
export function namesFor(places: Names["places"], node: string, parameter: string): readonly string[] | undefined {
  return optionsAt(places, [...node.split("/"), parameter]);
}

function loadNames(): void {
  server.names().then(
    (places) => useNames.setState({ places }),
    () => useNames.setState({ asked: false }),
  );
}
