// Lists of containers are edited as rows: rules, waits, cases; and what a task is given and hands out.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder] = rest;
const file = join(folder, "tasks/lists.yaml");
const BEFORE = `grip: 1
name: lists
data: {side: {type: str, value: left}}
root:
  kind: sequence
  children:
    both:
      kind: parallel
      outcomes: {done: success, over: failure}
      exits: {}
      children:
        one: {node: flow/wait, with: {seconds: 0.1}}
        two: {node: flow/fail, with: {code: slipped}}
    which:
      kind: switch
      on_value: side
      cases: {left: left, right: [right, 2]}
      children:
        left: {node: flow/succeed}
        right: {node: flow/succeed}
        other: {node: flow/succeed}
`;
writeFileSync(file, BEFORE);

await onPage(url, async (page, { answer, button, choose, fileIs, pick }) => {
  const saved = async () => {
    await page.keyboard.press("Control+s");
    await fileIs("saved");
    return readFileSync(file, "utf8");
  };
  await choose("Task", "tasks/lists.yaml");
  await fileIs("saved");

  // Rules: made, filled, put in order, taken out.
  const rules = page.getByRole("region", { name: "Rules" });
  await eventually(async () => {
    await pick("both"); // until what is selected first in a file that has just come has been
    return rules.count();
  }, 1);
  await rules.getByRole("button", { name: "New rule" }).click();
  const first = rules.getByRole("group", { name: "Rule 1" });
  await first.getByRole("group", { name: "two has ended with" }).getByLabel("failure", { exact: true }).check();
  await first.getByLabel("Then it ends with").selectOption("over");
  await rules.getByRole("button", { name: "New rule" }).click();
  const second = rules.getByRole("group", { name: "Rule 2" });
  await second.getByLabel("At least").fill("2");
  await second.getByLabel("At least").press("Enter");
  await second.getByLabel("Then it ends with").selectOption("done");
  await fileIs("not saved");
  await rules.getByRole("button", { name: "Move rule 2 up" }).click();
  await first.getByLabel("At least").and(page.locator('[value="2"]')).waitFor();
  assert.match(await saved(), /rules: \[\{at_least: 2, then: done\}, \{when: \{two: failure\}, then: over\}\]/);
  await check(page, "rules as rows");
  await rules.getByRole("button", { name: "Remove rule 1" }).click();
  await second.waitFor({ state: "detached" });

  // Whom it waits for.
  await page.getByLabel("Waits for").selectOption("count");
  await page.getByLabel("How many children").waitFor();
  await page.getByLabel("Waits for").selectOption("these");
  const waited = page.getByRole("group", { name: "Children that are waited for" });
  await waited.getByLabel("one").uncheck();
  await waited.getByLabel("two").and(page.locator(":disabled")).waitFor();
  assert.match(await saved(), /wait_for: \[two\]/);
  await page.getByLabel("Waits for").selectOption("");
  await waited.waitFor({ state: "detached" });

  // Cases.
  await pick("which");
  const cases = page.getByRole("region", { name: "Cases" });
  const right = cases.getByLabel("right is taken for");
  assert.equal(await right.inputValue(), '"right", 2');
  await right.fill("right, {");
  await right.press("Enter");
  await cases.getByText(/Literals with commas between them are needed/).waitFor();
  await right.fill("right, 3");
  await right.press("Enter");
  await cases.getByRole("button", { name: "New case" }).click();
  await cases.getByLabel("other is taken for").waitFor();
  await cases.getByRole("button", { name: "Move the case of other up" }).click();
  await cases.getByRole("button", { name: "Remove the case of left" }).click();
  await cases.getByLabel("left is taken for").waitFor({ state: "detached" });
  assert.match(await saved(), /cases: \{other: other, right: \[right, 3\]\}/);
  await check(page, "cases as rows");

  // What the task is given and hands out.
  await pick("lists");
  const inputs = page.getByRole("region", { name: "Inputs" });
  await inputs.getByRole("button", { name: "New input" }).click();
  await answer("height");
  await answer("float");
  await inputs.getByLabel("Value of height").fill("0.25");
  await inputs.getByLabel("Value of height").press("Enter");
  await page.getByRole("button", { name: "New output" }).click();
  await answer("height");
  await inputs.getByText("goes in and comes out").waitFor();
  await page.getByRole("region", { name: "Outputs" }).getByRole("button", { name: "New output" }).click();
  await answer("reached");
  await answer("Pose");
  assert.match(await saved(), /inputs: \{height: \{type: float, value: 0\.25\}\}\noutputs: \{height: float, reached: Pose\}/);
  await inputs.getByLabel("Type of height").fill("int");
  await inputs.getByLabel("Type of height").press("Enter");
  await inputs.getByLabel("Value of height").fill("2");
  await inputs.getByLabel("Value of height").press("Enter");
  await page.getByRole("region", { name: "Outputs" }).getByRole("button", { name: "Remove reached" }).click();
  await page.getByRole("region", { name: "Outputs" }).getByLabel("Type of reached").waitFor({ state: "detached" });
  assert.match(await saved(), /inputs: \{height: \{type: int, value: 2\}\}\noutputs: \{height: int\}/);
  await check(page, "inputs and outputs");

  // A comment is written above its node, read from the text again, and shows in the history by words.
  await pick("which");
  const comment = page.getByLabel("Comment in the file");
  await comment.and(page.locator(":enabled")).fill("left or right,\nas it was told");
  await pick("left");
  await fileIs("not saved");
  assert.match(await saved(), /\n    # left or right,\n    # as it was told\n    which:\n/);
  assert.equal(await comment.inputValue(), "");
  await pick("which");
  await page.waitForFunction(() => [...document.querySelectorAll("textarea")].some((area) => area.value === "left or right,\nas it was told"));
  await page.getByRole("tab", { name: "History" }).click();
  await page.getByRole("button", { name: "comment on which" }).waitFor();
  await check(page, "a comment");

  // That of the task stands at the top of its file; a line that is changed leaves the others alone.
  await pick("lists");
  const head = page.getByLabel("Comment at the top of the file");
  await head.and(page.locator(":enabled")).fill("rules, waits, cases\n\nand ports");
  await pick("which");
  await fileIs("not saved");
  assert.ok((await saved()).startsWith("# rules, waits, cases\n#\n# and ports\ngrip: 1\n"));
  await pick("lists");
  await page.waitForFunction(() => [...document.querySelectorAll("textarea")].some((area) => area.value === "rules, waits, cases\n\nand ports"));
  await head.fill("rules, waits, cases\n\nand all ports");
  await pick("which");
  await fileIs("not saved");
  assert.ok((await saved()).startsWith("# rules, waits, cases\n#\n# and all ports\ngrip: 1\n"));
  await page.getByRole("button", { name: "comment on the task" }).first().waitFor();

  // All of it is edits like others.
  while (await button("Undo").isEnabled()) {
    await button("Undo").click({ force: true });
    await page.waitForTimeout(60);
  }
  await page.keyboard.press("Control+s");
  await fileIs("saved");
  assert.equal(readFileSync(file, "utf8"), BEFORE);
});
