// A task is built, checked, run and stopped by keys alone, and what a screen reader has to say at each of them is printed: roles,
// names and states as Chromium's accessibility tree has them, and what the live regions tell. docs/study.md holds the same.
import assert from "node:assert/strict";

import { eventually, onPage, url } from "./page.mjs";

/** What is said of a property, where it is so. */
const STATES = { expanded: (value) => (value ? "expanded" : "collapsed"), selected: (value) => value && "selected", pressed: (value) => value === "true" && "pressed", invalid: (value) => value === "true" && "invalid", level: (value) => `level ${value}` };

await onPage(url, async (page) => {
  const devtools = await page.context().newCDPSession(page);
  await devtools.send("Accessibility.enable");
  const heard = [];

  /** Role, name, value and states of an element. */
  async function said(expression) {
    const { result } = await devtools.send("Runtime.evaluate", { expression });
    if (!result.objectId) return "";
    const { nodes } = await devtools.send("Accessibility.getPartialAXTree", { objectId: result.objectId, fetchRelatives: false }).catch(() => ({ nodes: [] }));
    const [node] = nodes;
    if (!node || node.ignored) return "";
    const role = { combobox: "combo box", treeitem: "tree item", textbox: "text field", spinbutton: "number field" }[node.role.value] ?? node.role.value;
    const states = (node.properties ?? []).map(({ name, value }) => STATES[name]?.(value.value)).filter(Boolean);
    // When a problem is found depends on how busy the machine is.
    return [node.name?.value.replace(/\b(error|warning), /, ""), role, node.value?.value && `"${node.value.value}"`, ...states].filter(Boolean).join(", ");
  }
  const spoken = async () => {
    const own = await said("document.activeElement");
    const option = await page.evaluate(() => document.getElementById(document.activeElement?.getAttribute("aria-activedescendant") ?? "")?.querySelector(".option-label")?.textContent);
    return option ? `${own}; ${option}, option` : own;
  };
  const press = async (keys, wanted) => {
    await page.keyboard.press(keys);
    const now = await eventually(spoken, (now) => wanted.test(now), `${keys} should lead to ${wanted}`);
    heard.push(`${keys}: ${now.split("; ")[0]}`); // which option a list begins with says nothing here
  };
  const key = async (keys) => {
    await page.keyboard.press(keys);
    heard.push(keys);
  };
  const type = async (text, wanted) => {
    await page.keyboard.type(text);
    heard.push(`types ${text}: ${await eventually(spoken, (now) => wanted.test(now), `typing ${text} should lead to ${wanted}`)}`);
  };
  /** What a live region tells; `name` is its accessible name. */
  const hear = async (name, wanted) => {
    const region = page.getByRole("status", { name, exact: true });
    const text = await eventually(async () => ((await region.count()) === 1 ? ((await region.textContent()) ?? "").trim() : ""), (now) => wanted.test(now), `${name} should tell ${wanted}`);
    heard.push(`  (${name}: ${text})`);
  };
  /** Go on by a key until the focus is on what is wanted. */
  const reach = async (keys, wanted) => {
    for (let times = 0; times < 60; times++) {
      await page.keyboard.press(keys);
      const now = await spoken();
      if (wanted.test(now)) return void heard.push(`${keys} ...: ${now}`);
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
  await key("Enter");
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
  await key("Enter");
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
  await key("Alt+r");
  await hear("State of the run", /^running/);
  await hear("What works now", /^wait /);
  await page.keyboard.press("F8");
  await hear("State of the run", /^stopped/);
  await eventually(spoken, (now) => /^wait .*interrupted/.test(now));
  heard.push(`F8: ${await spoken()}`);
  console.log(heard.join("\n"));
});
