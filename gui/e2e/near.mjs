// From afar and near: what nodes show and how they are edited where they stand; long lists of problems; drags inside open boxes.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder] = rest;
const many = Array.from({ length: 230 }, (_, i) => `    step_${i}: {node: flow/wait}`).join("\n");
writeFileSync(join(folder, "tasks/many.yaml"), `grip: 1\nname: many\nroot:\n  kind: sequence\n  children:\n${many}\n`);

await onPage(url, async (page, { button, choose, dragUntil, fileIs, item, pick }) => {
  const zoomIn = async (times) => {
    const nearer = page.getByRole("button", { name: "Zoom In" });
    for (let i = 0; i < times && (await nearer.isEnabled()); i++) await nearer.click();
  };
  await choose("Task", "tasks/short.yaml");
  await fileIs("saved");
  await pick("broken");
  const broken = page.locator('.react-flow [data-path="attempts/broken"]');
  await broken.getByText("flow/fail", { exact: true }).waitFor();
  assert.equal(await broken.getByText("the way is blocked").count(), 0);

  // Near, a node says what it is set to, and nothing has moved for it; the selected one has fields.
  const places = () => page.locator(".react-flow__node").evaluateAll((all) => Object.fromEntries(all.map((each) => [each.dataset.id, each.style.transform])));
  const before = await places();
  await zoomIn(6);
  await pick("broken");
  await broken.getByText("the way is blocked").waitFor();
  const after = await places();
  for (const [id, at] of Object.entries(after)) if (before[id]) assert.equal(at, before[id]);
  const near = page.getByRole("group", { name: "Settings of broken, at the node" });
  await near.getByLabel("message").fill("a box is in the way");
  await near.getByLabel("message").press("Enter");
  await broken.getByText("a box is in the way").waitFor();
  await fileIs("not saved");
  // The event alone: a chart that is laid out anew just then would leave the pointer beside the field.
  await near.getByLabel("message").dispatchEvent("dblclick");
  assert.equal(await button("Tree").getAttribute("aria-pressed"), "true", "a double click in a field stays in the field");
  await check(page, "fields at a node");
  await page.keyboard.press("Escape");
  await pick("attempts");
  await near.waitFor({ state: "detached" });

  // The same in a flow chart; a node inside an open box is dragged, and stays where it was put in the chart of its own container.
  await pick("machine");
  await button("Flow").click();
  await pick("short");
  await page.locator(".flow").getByRole("button", { name: "Inside of machine in place" }).click();
  const inner = page.locator('.flow [data-path="machine/b"]');
  await inner.waitFor();
  await page.getByRole("button", { name: "Fit View" }).click();
  await dragUntil(inner.locator(".node-name"), 40, 60, page.getByRole("button", { name: "Tidy up (1 pinned)" }));
  await page.keyboard.press("Control+s");
  await fileIs("saved");
  const [, x, y] = /machine\/b: \[(-?\d+), (-?\d+)\]/.exec(readFileSync(join(folder, "tasks/short.layout.yaml"), "utf8"));
  await pick("machine");
  await page.keyboard.press("Enter");
  await page.locator('.flow .react-flow__node[data-id="machine/b"]').and(page.locator(`[style*="translate(${x}px, ${y}px)"]`)).waitFor();
  await page.getByRole("button", { name: "Tidy up (1 pinned)" }).click();
  await page.getByRole("button", { name: /Tidy up/ }).waitFor({ state: "detached" });

  // A hundred problems at once, the others on demand.
  await choose("Task", "tasks/many.yaml");
  await button("Tree").click();
  await page.getByRole("heading", { name: /Problems: 230 errors/ }).waitFor();
  const lines = page.getByRole("list", { name: "Problems of the task" }).locator("li.error");
  await eventually(() => lines.count(), 100);
  await button("Show 100 more").click();
  await button("Show 30 more").click();
  await page.getByRole("button", { name: "step_229" }).waitFor();
  await eventually(() => lines.count(), 230);
  await item("step_0").waitFor();

  // Whoever comes to a view sees what is selected, also where a pane beside it has taken half of its room.
  await page.getByRole("button", { name: "step_200" }).click();
  for (const [view, pane] of [["Text", ".cm-editor"], ["Tree", ".react-flow"], ["Flow", ".flow .react-flow"], ["Split", ".flow .react-flow"]]) {
    await button(view).click();
    await page.locator(pane).waitFor();
    if (view === "Text") continue;
    await page.waitForFunction((pane) => {
      const around = document.querySelector(pane)?.getBoundingClientRect();
      const node = document.querySelector(`${pane} [data-path="step_200"]`)?.getBoundingClientRect();
      return around && node && node.left >= around.left && node.right <= around.right && node.top >= around.top && node.bottom <= around.bottom;
    }, pane);
  }
});
