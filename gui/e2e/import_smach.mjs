// A SMACH file: imported on the page, looked at as a flow chart, converted to a tree, edited, run.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { onPage, rest, url } from "./page.mjs";

const [folder, legacy] = rest;

await onPage(url, async (page, { answer, button, choose, item, nodeIs, runIs }) => {
  await button("Project").click();
  await page.getByText("Import a task").click();
  await check(page, "import");
  await page.getByLabel("File", { exact: true }).setInputFiles(legacy);
  await page.getByLabel("What the import said").getByText("1 partial").waitFor();
  await page.getByRole("list", { name: "Imported tasks" }).getByRole("button").click();

  // The machine as it was.
  const root = page.locator('[role="treeitem"][data-row="/"]');
  await page.locator('[data-row="FIRST"]').waitFor();
  await root.click();
  await button("Flow").click();
  await page.locator('.flow [data-path="FIRST"]').waitFor();
  await page.locator('.flow .react-flow__edge[data-id="FIRST.done"]').waitFor({ state: "attached" });

  // As a tree: first looked at, then done.
  await root.focus();
  await page.keyboard.press("Shift+K");
  await answer("To a behaviour tree");
  await page.getByRole("dialog").getByText("Both forms do the same").waitFor();
  await page.keyboard.press("Enter");
  await page.getByRole("dialog").waitFor({ state: "detached" });
  await button("Tree").click();
  await item("FIRST").focus();
  await page.keyboard.press("/");
  await answer("flow/wait");
  const seconds = page.getByLabel("seconds float");
  await seconds.fill("0.1");
  await seconds.press("Enter");
  await page.getByText("No problems.").waitFor();
  await choose("Robot", "fake");
  await button("Run").click();
  await runIs("success: finished");
  await nodeIs("wait", "success");
  const text = readFileSync(join(folder, "tasks/two_steps_make.yaml"), "utf8");
  assert.doesNotMatch(text, /state_machine/);
  assert.match(text, /node: flow\/wait/);
});
