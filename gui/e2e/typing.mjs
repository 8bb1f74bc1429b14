// Typing is safe: letters filter, Enter commits, nothing that is typed into a question reaches the task or the page; of two who set one thing the second is told.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url, words } from "./page.mjs";

const [folder] = rest;
const text = () => readFileSync(join(folder, "tasks/short.yaml"), "utf8");

await onPage(url, async (page, { button, choose, fileIs, item, pick, rowsAre }) => {
  await choose("Task", "tasks/short.yaml");
  await fileIs("saved");
  await item("attempts").waitFor();
  const before = text();
  const rows = await words(page).names();
  const view = () => page.getByRole("group", { name: "View" }).locator('[aria-pressed="true"]').textContent();

  // The kind of a container by its name, which has a space in it: nothing happens before Enter.
  await pick("attempts");
  await page.keyboard.press("k");
  const dialog = page.getByRole("dialog");
  await dialog.waitFor();
  await page.keyboard.type("state machine");
  await check(page, "letters in a question");
  assert.equal(await view(), "Tree");
  await rowsAre(rows);
  await fileIs("saved");
  await page.keyboard.press("Enter");
  await dialog.waitFor({ state: "detached" });
  await item("attempts").getByText("state machine").waitFor({ state: "attached" });
  assert.equal(await view(), "Tree");
  await button("Undo").click();
  await fileIs("saved");

  // Words that nothing is like: Enter takes nothing, and the question stays until Escape.
  for (const key of ["k", "w", "/", "c", "Control+k", "Control+f"]) {
    await pick("attempts");
    await page.keyboard.press(key);
    await dialog.waitFor();
    await page.keyboard.type("t o c x w/ no such thing");
    await page.keyboard.press("Enter");
    await dialog.getByText(/Nothing is like/).waitFor();
    await page.keyboard.press("Escape");
    await dialog.waitFor({ state: "detached" });
    assert.equal(await view(), "Tree");
    await rowsAre(rows);
    await fileIs("saved");
  }

  // A few buttons are filtered, too: letters leave those that they mean.
  await pick("attempts");
  await page.keyboard.press("Shift+K");
  await dialog.getByRole("button", { name: /To a behaviour tree/ }).waitFor();
  await page.keyboard.type("states and edges");
  await eventually(() => dialog.locator(".few-choices [role=group] button:visible").allTextContents().then((all) => all.length), 1);
  await page.keyboard.press("Backspace");
  await page.keyboard.press("Escape");
  await dialog.waitFor({ state: "detached" });

  // Every outcome leads somewhere: that is good news.
  await pick("machine");
  await page.keyboard.press("Shift+C");
  await page.getByLabel("What was done").getByText(/leads somewhere already|connected/).waitFor();
  assert.equal(await page.getByRole("alert").count(), 0);
  if ((await page.getByLabel("State of the file").textContent()) !== "saved") await button("Undo").click();
  await fileIs("saved");
  assert.equal(text(), before);

  // Two people in one field: what the second one types stays, and says what has happened to it.
  const other = await page.context().newPage();
  await other.goto(url);
  const two = words(other);
  await other.getByRole("tree").waitFor();
  await two.choose("Task", "tasks/short.yaml");
  const seconds = (on) => on.getByLabel(/^seconds/).first();
  await two.pick("first");
  await seconds(other).fill("7");
  await page.bringToFront();
  await pick("first");
  await seconds(page).fill("3");
  await page.keyboard.press("Enter");
  await eventually(() => seconds(other).evaluate((field) => [field.value, document.getElementById(field.getAttribute("aria-describedby")).textContent]), ([value, told]) => value === "7" && /Somebody set this to 3 meanwhile/.test(told));
  await other.bringToFront();
  await seconds(other).blur();
  await eventually(() => seconds(page).inputValue(), "3");
  await seconds(other).focus();
  await other.keyboard.press("Enter");
  await eventually(() => seconds(page).inputValue(), "7");

  // A node that goes under somebody's hands: the other one learns the true cause.
  await two.pick("second");
  await page.bringToFront();
  await pick("second");
  await page.keyboard.press("Delete");
  await other.getByRole("alert").getByText("attempts/second was removed elsewhere").waitFor();
  assert.equal(await page.getByRole("alert").count(), 0);
  await other.close();
});
