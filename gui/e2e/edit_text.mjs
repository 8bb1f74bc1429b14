// The text: typed, completed, marked where it is wrong, kept when it is no task, and one history with the drawings.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { eventually, onPage, rest, url, words } from "./page.mjs";

const [folder] = rest;
const path = join(folder, "tasks/short.yaml");

await onPage(url, async (page, { button, choose, fileIs, item, pick, rowsAre }) => {
  const line = (words) => page.locator(".cm-line", { hasText: words });
  const before = readFileSync(path, "utf8");
  await choose("Task", "tasks/short.yaml");
  await fileIs("saved");
  await button("Text").click();

  // One selection: the outline marks the line, the cursor selects the node.
  await pick("second");
  await page.locator(".cm-node-line", { hasText: "second:" }).waitFor();
  await line("machine:").click();
  await page.locator('[role="treeitem"][aria-selected="true"][data-row="machine"]').waitFor();

  // Typing is an edit; a node of the catalogue is completed.
  await line("first:").click();
  await page.keyboard.press("End");
  await page.keyboard.press("Enter");
  await page.keyboard.type("added: {node: flow/suc");
  await page.locator(".cm-tooltip-autocomplete").getByText("flow/succeed").click();
  await page.waitForFunction(() => [...document.querySelectorAll(".cm-line")].some((l) => l.textContent.includes("flow/succeed")));
  await rowsAre(["/", "first", "added", "attempts", "attempts/broken", "attempts/second", "machine", "machine/a", "machine/b"]);
  // What is typed with pauses is several steps.
  await eventually(async () => {
    await page.keyboard.press("Control+z");
    return item("added").count();
  }, 0);

  // What is no task is marked at its place, kept, saved as it is; the drawings say that they show an older one.
  await line("first:").click();
  await page.keyboard.press("Home");
  await page.keyboard.type("oops: - ");
  await fileIs("text isn't a task");
  await page.locator(".cm-lintRange-error").first().waitFor();
  await page.getByText(/This text isn't a task yet/).waitFor();
  await button("Tree").click();
  await page.getByText(/the last valid version is shown/).waitFor();
  await item("first").focus();
  await page.keyboard.press("Delete");
  await page.getByRole("alert").getByText(/the text is not a valid task/).waitFor();
  await page.getByRole("alert").getByRole("button", { name: "Close" }).click();
  await page.keyboard.press("Control+s");
  await eventually(() => readFileSync(path, "utf8"), (saved) => /oops: - first:/.test(saved));
  await eventually(async () => {
    if (await button("Undo").isEnabled()) await button("Undo").click({ timeout: 2000 }).catch(() => {}); // it may be the last one that is under way
    await page.keyboard.press("Control+s");
    return readFileSync(path, "utf8");
  }, before);
  await fileIs("saved");

  // A fix of the problems list is an edit; the squiggle goes.
  await button("Text").click();
  await line("first:").click();
  await page.keyboard.press("End");
  for (let i = 0; i < "t, with: {seconds: 0.5}}".length; i++) await page.keyboard.press("ArrowLeft");
  await page.keyboard.type("z");
  await page.getByRole("button", { name: "Use flow/wait" }).first().click();
  await page.getByText("No problems.").waitFor();
  await fileIs("saved");

  // Another page sees every edit; what was typed on an older text is neither lost nor silently put over it.
  const other = await page.context().newPage();
  const two = words(other);
  await other.goto(url);
  await other.getByRole("tree").waitFor();
  await two.choose("Task", "tasks/short.yaml");
  await two.pick("first");
  await other.keyboard.press("F2");
  await two.answer("theirs");
  await page.bringToFront();
  await item("theirs").waitFor();
  await line("theirs:").waitFor();

  // Somebody else writes the file: nothing is overwritten unseen.
  writeFileSync(path, before.replace("first:", "outside:"));
  await line("theirs:").click();
  await button("Tree").click();
  await page.keyboard.press("Control+s");
  await page.getByRole("alert").getByText(/changed outside the editor/).waitFor();
  assert.match(readFileSync(path, "utf8"), /outside:/);
  await page.getByRole("alert").getByRole("button", { name: "Reload from the file" }).click();
  await item("outside").waitFor();
  await button("Undo").click();
  await item("theirs").waitFor();
  await page.keyboard.press("Control+s");
  await eventually(() => readFileSync(path, "utf8"), (saved) => /theirs:/.test(saved));
});
