// A part of a task becomes a file of its own and comes back; the way into the file and out of it.
import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { onPage, rest, url } from "./page.mjs";

const [folder] = rest;

await onPage(url, async (page, { answer, button, choose, fileIs, item, more, pick, rowsAre }) => {
  const whole = ["/", "first", "attempts", "attempts/broken", "attempts/second", "machine", "machine/a", "machine/b"];
  await choose("Task", "tasks/short.yaml");
  await fileIs("saved");
  await rowsAre(whole);

  // Extract: the file is named, a name that won't do is refused in the dialog.
  await pick("attempts");
  await more("Extract");
  const dialog = page.getByRole("dialog", { name: "Extract attempts to a task of its own" });
  assert.equal(await dialog.getByLabel("File").inputValue(), "tasks/attempts.yaml");
  await dialog.getByLabel("File").fill("tasks/long.yaml");
  await dialog.getByText("A task with this name exists already.").waitFor();
  await dialog.getByLabel("File").fill("../elsewhere.yaml");
  await dialog.getByText(/A task file lies below tasks/).waitFor();
  await answer("tasks/attempts.yaml");
  await rowsAre(["/", "first", "attempts", "machine", "machine/a", "machine/b"]);
  await item("attempts").getByText("subtask").waitFor({ state: "attached" });
  const made = readFileSync(join(folder, "tasks/attempts.yaml"), "utf8");
  assert.match(made, /inputs: \{reached: /);
  assert.match(made, /broken: \{node: flow\/fail, with: \{code: no_plan, message: the way is blocked\}\}/);
  await page.getByText("No problems.").waitFor();

  // In: the file's task, with the way back; out, at the subtask.
  await button("Open").click();
  await rowsAre(["/", "broken", "second"]);
  const above = page.getByRole("navigation", { name: "Tasks above" });
  await above.getByRole("button", { name: "short/attempts" }).waitFor();
  await check(page, "in a subtask");
  await above.getByRole("button", { name: "short/attempts" }).click();
  await rowsAre(["/", "first", "attempts", "machine", "machine/a", "machine/b"]);
  await page.locator('[role="treeitem"][aria-selected="true"][data-row="attempts"]').waitFor();
  await above.waitFor({ state: "detached" });

  // By keys, through the flow chart: Enter goes in, Backspace comes back.
  await page.keyboard.press("t");
  await page.locator('.flow [data-path="attempts"]').waitFor();
  await item("attempts").focus();
  await page.keyboard.press("Enter");
  await page.locator('.flow [data-path="broken"]').waitFor();
  await page.keyboard.press("Backspace");
  await page.locator('.flow [data-path="attempts"]').waitFor();
  await button("Tree").click();

  // In a pane of its own.
  const [pane] = await Promise.all([page.waitForEvent("popup"), page.getByRole("link", { name: "Open the subtask in a pane of its own" }).click()]);
  await pane.getByRole("treeitem", { name: /^second / }).waitFor();
  await pane.close();

  // Undo gives the bytes back, and the file stays.
  await pick("attempts");
  await page.keyboard.press("Control+z");
  await rowsAre(whole);
  await fileIs("saved");
  assert.ok(existsSync(join(folder, "tasks/attempts.yaml")));

  // Where it would make a difference the person is asked: what a time-out may halt hands nothing out.
  await pick("machine");
  await page.keyboard.press("w");
  await answer("timeout");
  await item("timeout").waitFor({ state: "attached" }); // which is selected then
  await pick("b");
  await more("Extract");
  await answer("tasks/counting.yaml");
  const question = page.getByRole("dialog", { name: "Extract b?" });
  await question.getByText(/the timeout timeout may halt it/).waitFor();
  await question.getByRole("button", { name: /Leave it as it is/ }).click();
  assert.ok(!existsSync(join(folder, "tasks/counting.yaml")));
  await item("b").getByText("leaf").waitFor({ state: "attached" });
  await more("Extract");
  await answer("tasks/counting.yaml");
  await question.getByRole("button", { name: /anyway/ }).click();
  await item("b").getByText("subtask").waitFor({ state: "attached" });
  assert.match(readFileSync(join(folder, "tasks/counting.yaml"), "utf8"), /node: test\/count/);
});
