// What the page can't decide: derived edges, edges that can mean several things, forms that only one view edits; and what people wrote stays.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder] = rest;
const file = join(folder, "tasks/tangled.yaml");
writeFileSync(
  file,
  `grip: 1
name: tangled
root:
  kind: state_machine
  # why it begins here
  initial: a
  outcomes: {success: success}
  children:
    # tries the short way
    a: {node: flow/fail, with: {code: x, message: m}, on: {failure: b, failure.failed: c}}
    b: {node: flow/wait, with: {seconds: 1}, on: {success: c}}  # gives it time
    c: {node: flow/fail, with: {code: x, message: m}, on: {failure: b, failure.failed: success}}
`,
);

await onPage(url, async (page, { button, choose, fileIs, item, pick }) => {
  const box = (path) => page.locator(`.flow [data-path="${path}"]`);
  const port = (path, outcome) => box(path).locator(".port", { hasText: outcome }).locator(".react-flow__handle");
  const edge = (name) => page.locator(`.flow .react-flow__edge[data-id="${name}"]`);
  const kindIs = (name, kind) => item(name).getByText(kind).waitFor({ state: "attached" });
  const remove = async (name) => {
    await edge(name).locator("path").first().click({ force: true });
    await page.getByRole("button", { name: "Remove this edge" }).click();
  };

  // A derived edge follows from the order: it isn't removed alone, which is said, and Escape leaves all as it was.
  await choose("Task", "tasks/short.yaml");
  await fileIs("saved");
  await pick("short");
  await button("Flow").click();
  await edge("first.success").waitFor({ state: "attached" });
  await remove("first.success");
  const why = page.getByRole("dialog", { name: "This edge follows from the order of the children" });
  await why.getByText(/short is a sequence; only the edges of a state machine/).waitFor();
  assert.equal(await why.getByRole("textbox").count(), 0, "one choice needs no filter");
  await page.keyboard.press("Escape");
  await why.waitFor({ state: "detached" });
  await fileIs("saved");
  await remove("first.success");
  await why.getByRole("button", { name: /Make short a state machine/ }).click();
  await kindIs("short", "state machine");
  await page.locator('.flow .stored[data-id="first.success"]').waitFor({ state: "attached" }); // the machine is drawn, too
  await remove("first.success");
  await edge("first.success").waitFor({ state: "detached" });
  await button("Undo").click();
  await edge("first.success").waitFor({ state: "attached" });
  await button("Undo").click();
  await kindIs("short", "sequence");
  await fileIs("saved");

  const still = async (what) => {
    let before;
    await eventually(async () => [before, (before = JSON.stringify(await what.boundingBox()))], ([then, now]) => then === now);
  };
  // What an edge between children can mean is asked; the next time, the last answer stands first.
  const draw = async () => {
    await still(box("machine")); // a box that is being laid out anew is missed
    await port("attempts", "failure").dragTo(box("machine").locator(".react-flow__handle-left"));
  };
  const asked = page.getByRole("dialog", { name: "attempts.failure to machine?" });
  await draw();
  assert.match(await asked.getByRole("group").getByRole("button").first().textContent(), /fallback\(attempts, machine\)/);
  await check(page, "a few choices");
  // By keys: the first has the focus, arrows go round, letters leave what they mean, Enter takes it.
  const focused = () => page.evaluate(() => document.activeElement?.querySelector(".option-label")?.textContent ?? document.activeElement?.textContent);
  await eventually(focused, "fallback(attempts, machine)");
  for (const [key, wanted] of [["ArrowDown", "Make short a state machine"], ["ArrowDown", "fallback(attempts, machine)"], ["ArrowUp", "Make short a state machine"], ["Home", "fallback(attempts, machine)"], ["Tab", "Make short a state machine"], ["Tab", "Cancel"], ["Shift+Tab", "Make short a state machine"], ["f", "fallback(attempts, machine)"], ["Backspace", "fallback(attempts, machine)"], ["m", "Make short a state machine"]]) {
    await page.keyboard.press(key);
    assert.equal(await focused(), wanted, key);
  }
  await page.keyboard.press("Enter");
  await asked.waitFor({ state: "detached" });
  await kindIs("short", "state machine");
  await button("Undo").click();
  await kindIs("short", "sequence");
  await draw();
  await asked.getByRole("button", { name: "Cancel" }).click();
  await asked.waitFor({ state: "detached" });
  await draw();
  await asked.getByText("as last time").waitFor();
  assert.match(await asked.getByRole("group").getByRole("button").first().textContent(), /Make short a state machine/);
  await asked.getByRole("button", { name: /fallback\(attempts, machine\)/ }).click();
  await item("machine").and(page.locator('[aria-level="3"]')).waitFor({ state: "attached" });

  // Two branches of the history: what was left is reached again from the list.
  await button("Undo").click();
  await item("machine").and(page.locator('[aria-level="2"]')).waitFor({ state: "attached" });
  await pick("second");
  await page.keyboard.press("Delete");
  await item("second").waitFor({ state: "detached" });
  await page.getByRole("tab", { name: "History" }).click();
  const moments = page.getByRole("list", { name: "History" });
  await moments.getByText("(branch)").first().waitFor();
  const left = moments.getByRole("button").filter({ hasText: "state machine" }).first();
  await left.click();
  await kindIs("short", "state machine");
  await item("second").waitFor({ state: "attached" });
  await moments.getByRole("button").last().click();
  await fileIs("saved");

  // Which edges keep a machine from being a tree; each leads to its node. What people wrote in the file outlives edits.
  await choose("Task", "tasks/tangled.yaml");
  await fileIs("saved");
  await pick("tangled");
  await button("Flow").click();
  await page.getByText("~ one form only: why?").first().click();
  const edges = page.locator(".form-why[open]").first();
  await edges.locator("p").filter({ hasText: /\S/ }).waitFor();
  const [first] = await edges.getByRole("button").allTextContents();
  assert.match(first, /^[abc]\.(success|failure)/);
  await edges.getByRole("button", { name: first, exact: true }).first().click();
  await page.locator(`[role="treeitem"][aria-selected="true"][data-row="${first.split(".")[0]}"]`).waitFor();
  await pick("b");
  const words = page.getByRole("textbox", { name: "Documentation" });
  await words.fill("Gives the gripper time.");
  await words.press("Tab");
  await fileIs("not saved");
  await page.keyboard.press("Control+s");
  await fileIs("saved");
  const text = readFileSync(file, "utf8");
  assert.match(text, /Gives the gripper time\./);
  for (const comment of ["# why it begins here", "# tries the short way", "# gives it time"]) assert.ok(text.includes(comment), text);
});
