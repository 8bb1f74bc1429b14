// Run a task to its end, see statuses change, and look at earlier moments on the time line.
import assert from "node:assert/strict";

import { eventually, onPage, url } from "./page.mjs";

await onPage(url, async (page, { button, choose, nodeIs, runIs, slider }) => {
  await choose("Task", "tasks/short.yaml");
  await choose("Robot", "fake");
  await nodeIs("first", "not started");
  await button("Run").click();
  await runIs("success: success");
  await nodeIs("first", "success");
  await nodeIs("broken", "failure.no_plan");
  await nodeIs("machine", "done \\(success\\)");
  assert.ok(await page.getByText("the way is blocked").first().isVisible(), "the reason is shown at the node");

  // The variable has its last value now, and its first one at the beginning.
  const row = page.getByRole("row", { name: /^reached / });
  await row.getByText("2", { exact: true }).waitFor();

  await slider().focus();
  await page.keyboard.press("Home");
  await nodeIs("first", "not started");
  await nodeIs("machine", "not started");
  await row.getByText("0", { exact: true }).waitFor();
  const last = Number(await slider().getAttribute("aria-valuemax"));
  const texts = [];
  for (let i = 0; i < last && !/first starts/.test(texts.at(-1) ?? ""); i++) {
    await page.keyboard.press("ArrowRight");
    await eventually(() => slider().getAttribute("aria-valuenow"), String(i + 1));
    texts.push(await slider().getAttribute("aria-valuetext"));
  }
  assert.match(texts.at(-1), /first starts/);
  await nodeIs("first", "running");
  await page.keyboard.press("End");
  await nodeIs("first", "success");

  // The same by pointer: the far left is the beginning.
  const box = await slider().boundingBox();
  await page.mouse.click(box.x + 1, box.y + box.height / 2);
  await nodeIs("machine", "not started");
  await button("Latest").click();
  await nodeIs("machine", "done \\(success\\)");

  // A page that is opened later shows the same run.
  await page.reload();
  await nodeIs("broken", "failure.no_plan");
});
