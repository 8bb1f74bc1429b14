// Containers in a flow chart: opened in place, edited there, closed; an edge to its own node goes round it.
import assert from "node:assert/strict";

import { check } from "./axe.mjs";
import { eventually, onPage, url } from "./page.mjs";

await onPage(url, async (page, { answer, button, choose, fileIs, item, pick }) => {
  const box = (path) => page.locator(`.flow [data-path="${path}"]`);
  const edge = (name) => page.locator(`.flow .react-flow__edge[data-id="${name}"]`);
  await choose("Task", "tasks/short.yaml");
  await fileIs("saved");
  await button("Flow").click();
  await box("machine").waitFor();
  assert.equal(await box("machine/a").count(), 0);

  // In place, by the mark: what is inside lies in the box, with its own ends.
  const inside = page.locator(".flow").getByRole("button", { name: "Inside of machine in place" });
  await inside.click();
  await box("machine/a").waitFor();
  await edge("machine/a.success").waitFor({ state: "attached" });
  const boxes = async (...all) => Promise.all(all.map((each) => each.boundingBox()));
  await eventually(
    () => boxes(box("machine"), box("machine/a")),
    ([around, within]) => within.x > around.x && within.y > around.y && within.x + within.width < around.x + around.width && within.y + within.height < around.y + around.height,
    "what is inside isn't in the box",
  );
  // Its end is its outcome on its border.
  await eventually(
    async () => [await edge("machine/b.success").locator("path").first().boundingBox(), await box("machine").boundingBox()],
    ([line, around]) => Math.abs(line.x + line.width - (around.x + around.width)) < 8,
    "the end isn't on the border",
  );

  // Selecting inside stays in this chart; what is edited is drawn where it is.
  await pick("b");
  await page.getByRole("navigation", { name: "Containers" }).getByRole("button", { name: "short" }).and(page.locator('[aria-current="location"]')).waitFor();
  await page.keyboard.press("F2");
  await answer("last");
  await box("machine/last").waitFor();
  await check(page, "a container open in place");

  // By keys, two at once; a loop goes round its node.
  await pick("second");
  await page.keyboard.press("w");
  await answer("repeat");
  await item("repeat").waitFor();
  await pick("short");
  await pick("attempts");
  await page.keyboard.press("Shift+Enter");
  await box("attempts/repeat").waitFor();
  await pick("repeat");
  await page.keyboard.press("Shift+Enter");
  const looped = box("attempts/repeat/second");
  await looped.waitFor();
  await eventually(
    () => boxes(edge("attempts/repeat/second.success").locator("path").first(), looped),
    ([loop, node]) => (loop.y + loop.height > node.y + node.height || loop.y < node.y) && loop.x < node.x && loop.x + loop.width > node.x + node.width,
    "the loop doesn't go round its node",
  );

  // Closed again: only the box is left. By its key: the chart still moves to what was selected, and the mark with it.
  await pick("machine");
  await page.keyboard.press("Shift+Enter");
  await box("machine/last").waitFor({ state: "detached" });

  // A double click goes in (on a chart that stays where it is); from afar a chart has no small print.
  await page.getByRole("button", { name: "Fit View" }).click();
  await pick("machine");
  await box("machine").locator(".node-name").dblclick();
  await box("machine/last").waitFor();
  await item("last").waitFor();
  // Who has asked for the whole goes on seeing it in a smaller window, also where it can hardly be read.
  await button("Tree").click();
  await pick("short");
  await button("Flow").click();
  await box("machine").waitFor();
  await page.getByRole("button", { name: "Fit View" }).click();
  await page.setViewportSize({ width: 820, height: 560 });
  const pane = page.locator(".flow .react-flow");
  await eventually(
    async () => Promise.all([pane.boundingBox(), ...(await page.locator(".flow .react-flow__node").all()).map((each) => each.boundingBox())]),
    ([around, ...all]) => all.length > 2 && all.every((each) => each && each.x >= around.x && each.x + each.width <= around.x + around.width),
    "something is out of sight",
  );
  await page.setViewportSize({ width: 1280, height: 720 });
  for (let i = 0; i < 8; i++) await page.getByRole("button", { name: "Zoom Out" }).click();
  await page.locator(".flow .react-flow.far").waitFor();
});
