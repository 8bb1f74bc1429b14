// A task is built, connected, checked, saved, run and stopped by keys alone, and a screen reader has to say what is right at each of them.
import assert from "node:assert/strict";

import { ear } from "./ear.mjs";
import { eventually, onPage, url } from "./page.mjs";

await onPage(url, async (page) => {
  const { spoken } = await ear(page);
  const press = async (keys, wanted) => {
    await page.keyboard.press(keys);
    await eventually(spoken, (now) => wanted.test(now), `${keys} should lead to ${wanted}`);
  };
  const type = async (text, wanted) => {
    await page.keyboard.type(text);
    await eventually(spoken, (now) => wanted.test(now), `typing ${text} should lead to ${wanted}`);
  };
  /** What a live region tells; `name` is its accessible name. */
  const hear = async (name, wanted) => {
    const region = page.getByRole("status", { name, exact: true });
    await eventually(async () => ((await region.count()) === 1 ? ((await region.textContent()) ?? "").trim() : ""), (now) => wanted.test(now), `${name} should tell ${wanted}`);
  };
  /** Go on by a key until the focus is on what is wanted. */
  const reach = async (keys, wanted) => {
    for (let times = 0; times < 60; times++) {
      await page.keyboard.press(keys);
      if (wanted.test(await spoken())) return;
    }
    assert.fail(`${keys} never leads to ${wanted}`);
  };

  await press("Control+k", /^Type to find a command, combo box/);
  await type("new task", /; New task, option/);
  await press("Enter", /^Name, text field/);
  await type("by_ear", /"by_ear"/);
  await press("Enter", /^by_ear .*tree item/);

  // Two steps, and what they are set to.
  await press("/", /combo box/);
  await type("flow/log", /; flow\/log, option/);
  await press("Enter", /^log .*tree item/);
  await reach("F6", /^Documentation, text field/);
  await reach("Tab", /^message/);
  await type("hello", /"hello"/);
  await page.keyboard.press("Enter");
  await hear("Problems", /^No problems\.$/);
  await reach("Shift+F6", /tree item/);
  await press("Home", /^by_ear .*tree item/);
  await press("k", /combo box/);
  await type("state machine", /; state machine, option/);
  await press("Enter", /^by_ear state machine.*tree item/);
  await press("ArrowDown", /^log .*tree item/);
  await press("/", /combo box/);
  await type("flow/wait", /; flow\/wait, option/);
  await press("Enter", /^wait .*tree item/);
  await reach("F6", /^Documentation, text field/);
  await reach("Tab", /^seconds/);
  await type("600", /"600"/);
  await page.keyboard.press("Enter");
  await reach("Shift+F6", /tree item/);

  // Edges between them.
  await press("ArrowUp", /^log .*tree item/);
  await press("c", /^success .*button/);
  await press("Enter", /button/);
  await reach("ArrowDown", /^wait sibling, button/);
  await press("Enter", /^log .*tree item/);
  await hear("What was done", /^log.success leads to wait$/);
  await press("ArrowDown", /^wait .*tree item/);
  await press("c", /^success .*button/);
  await press("Enter", /button/);
  await reach("ArrowDown", /^success .*button/);
  await press("Enter", /^wait .*tree item/);
  await hear("What was done", /^wait.success leads to success$/);

  // What is wrong: a warning, in the panel below the views.
  await hear("Problems", /^1 problem$/);
  await reach("F6", /tab,/);
  await reach("Tab", /^\/, button/);
  await reach("F6", /tree item/);

  // Saved, run, stopped.
  await press("Control+s", /tree item/);
  await hear("State of the file", /^saved$/);
  await reach("Shift+F6", /^Task, combo box/);
  await reach("Tab", /^Robot, combo box/);
  await press("f", /"fake"/);
  await reach("F6", /tree item/);
  await page.keyboard.press("Alt+r");
  await hear("State of the run", /^running/);
  await hear("What works now", /^wait /);
  await page.keyboard.press("F8");
  await hear("State of the run", /^stopped/);
  await eventually(spoken, (now) => /^wait .*interrupted/.test(now));
});
