// A conversion that isn't the same shows where: the counterexample is played on the page, in both forms.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder] = rest;
const file = join(folder, "tasks/watch.yaml");
writeFileSync(
  file,
  `grip: 1
name: watch
root:
  kind: sequence
  memory: false
  children:
    look: {node: flow/wait, with: {seconds: 0.1}, meaning: {success: success}}
    arm: {node: flow/wait, with: {seconds: 0.1}}
`,
);

await onPage(url, async (page, { answer, button, choose, fileIs, more, pick }) => {
  await choose("Task", "tasks/watch.yaml");
  await fileIs("saved");
  await pick("watch");

  // What asks again on every tick has no equal machine; roughly, the difference is found and can be played.
  await more("Convert");
  await answer("approximately");
  const dialog = page.getByRole("dialog", { name: "watch as a state machine" });
  await dialog.getByText(/They are not the same/).waitFor();
  await check(page, "dialog with a counterexample");
  await dialog.getByRole("button", { name: /Play it as it is/ }).click();

  // Both plays end by themselves, on the time line, event by event.
  const slider = page.getByRole("slider", { name: "Moment of the run" });
  const ended = () => page.waitForFunction(() => {
    const bar = document.querySelector('[role="slider"]');
    return bar?.getAttribute("aria-valuenow") === bar?.getAttribute("aria-valuemax");
  });
  await page.getByText("Counterexample", { exact: true }).waitFor();
  await page.getByRole("button", { name: "Hold" }).waitFor();
  await ended();
  const spansOf = () => page.locator(".time-track .span").allTextContents();
  const looks = async () => (await spansOf()).filter((name) => name === "look").length;
  await eventually(looks, (count) => count > 1, "look is asked again as it is");
  await check(page, "a counterexample");

  await page.getByRole("group", { name: "Form that is played" }).getByRole("button", { name: "Then" }).click();
  await page.getByRole("treeitem", { name: /^watch state machine/ }).waitFor();
  await ended();
  await eventually(looks, 1, "look is asked once as it would be");

  // Any moment can be looked at, and the play goes on from there.
  await slider.focus();
  await page.keyboard.press("Home");
  await button("Play").click();
  await Promise.race([button("Hold").click(), ended()]); // a browser that is slow comes too late to hold it
  await button("Play").waitFor();

  // Nothing was changed so far; then it is decided.
  assert.match(readFileSync(file, "utf8"), /memory: false/);
  await button("Decide").click();
  await dialog.getByRole("button", { name: /Leave it as it is/ }).click();
  await page.getByRole("treeitem", { name: /^watch sequence/ }).waitFor();
  await fileIs("saved");
  await more("Convert");
  await answer("approximately");
  await dialog.getByRole("button", { name: /Convert anyway/ }).click();
  await page.getByRole("treeitem", { name: /^watch state machine/ }).waitFor();
  await page.keyboard.press("Control+z");
  await page.getByRole("treeitem", { name: /^watch sequence/ }).waitFor();
  await fileIs("saved");
});
