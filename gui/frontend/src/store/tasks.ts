/** Task files of the project: the list, and new ones. */
import { create } from "zustand";

import { server } from "../protocol/client";
import type { ProjectView } from "../protocol/generated";
import { askText } from "./ask";
import { chooseTask } from "./desk";
import { useDocument } from "./document";
import { goToTree } from "./panels";
import { useRun } from "./run";

export const useProject = create<{ readonly project: ProjectView | null }>()(() => ({ project: null }));

export async function loadProject(): Promise<ProjectView> {
  const project = await server.project();
  useProject.setState({ project });
  return project;
}

export async function newTask(): Promise<void> {
  const taken = new Set(useProject.getState().project?.tasks.map((task) => task.path));
  const check = (name: string): string => {
    if (!/^[A-Za-z_][A-Za-z0-9_ /-]*$/.test(name)) return "A name has letters, digits, _, - and spaces; / makes a folder.";
    return taken.has(`tasks/${name}.yaml`) ? "A task of this name is there." : "";
  };
  const name = await askText({ title: "New task", label: "Name", initial: "", hint: "It becomes tasks/<name>.yaml", check });
  if (name === null) return;
  try {
    await server.newTask({ path: `tasks/${name}.yaml`, text: null });
    await Promise.all([loadProject(), server.catalog().then(useDocument.getState().setCatalog)]);
    await chooseTask(`tasks/${name}.yaml`);
    goToTree();
  } catch (error) {
    useRun.getState().setTrouble(error instanceof Error ? error.message : String(error));
  }
}
