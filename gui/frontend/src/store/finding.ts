/** Search over everything in a task: names, kinds, documentation, values, variables. */
import { findings } from "../model/search";
import { askChoice } from "./ask";
import { usePage } from "./page";
import { useRun } from "./run";

export async function find(): Promise<void> {
  const found = findings(useRun.getState().task);
  const path = await askChoice({ title: "Search", label: "Search names, values, variables, documentation", options: found, search: true });
  if (path !== null) usePage.getState().select(path.split("\n")[0] as string);
}
