// A task is edited while a run of it is paused: the run keeps the text that it began with, the next one has the new.
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { eventually, onPage, rest, url } from "./page.mjs";

const [folder] = rest;

await onPage(url, async (page, { answer, button, choose, fileIs, item, nodeIs, pick, runIs }) => {
  const selected = () => page.getByRole("treeitem", { selected: true }).getAttribute("data-row");
  await choose("Task", "tasks/short.yaml");
  await choose("Robot", "fake");
  await pick("second");
  await page.keyboard.press("F9");
  await page.getByRole("treeitem", { name: /^second .*breakpoint before/ }).waitFor();
  await button("Run").click();
  await runIs("paused before attempts/second (breakpoint)");
  await nodeIs("broken", "failure.no_plan");

  // The record can't be edited; the task can, and the page says what that means for the run.
  await page.getByText("Record of a run: read only").waitFor();
  await button("Edit the task").click();
  await page.getByText("A run goes on with the text that it began with").waitFor();
  await pick("b");
  await page.keyboard.press("F2");
  await answer("later");
  await item("later").waitFor();
  await page.keyboard.press("Control+s");
  await fileIs("saved");
  await eventually(() => readFileSync(join(folder, "tasks/short.yaml"), "utf8"), (saved) => /later: \{node: test\/count/.test(saved));
  await eventually(selected, "machine/later", "where the run holds doesn't take the selection away from who edits");
  await runIs("paused before attempts/second (breakpoint)");

  await button("Show the run").click();
  await nodeIs("broken", "failure.no_plan");
  await item("b").waitFor();
  await button("Resume").click();
  await runIs("success: success");
  await nodeIs("b", "success");

  await button("Run").click();
  await runIs("paused before attempts/second (breakpoint)");
  await button("Resume").click();
  await runIs("success: success");
  await nodeIs("later", "success");
});
