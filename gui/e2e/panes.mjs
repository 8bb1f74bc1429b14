// Room to look: panes are dragged, put away and remembered; what isn't wrong takes a line; the robot in 3D as the main view says that it loads.
import assert from "node:assert/strict";

import { check } from "./axe.mjs";
import { eventually, onPage, url } from "./page.mjs";

await onPage(url, async (page, { answer, button, choose, fileIs, pick }) => {
  const width = async (selector) => (await page.locator(selector).boundingBox())?.width ?? 0;
  const height = async (selector) => (await page.locator(selector).boundingBox())?.height ?? 0;
  const drag = async (selector, right, down) => {
    const { x, y, width, height } = await page.locator(selector).boundingBox();
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + width / 2 + right, y + height / 2 + down, { steps: 4 });
    await page.mouse.up();
  };
  const about = (wanted) => (found) => Math.abs(found - wanted) <= 2;
  await choose("Task", "tasks/short.yaml");
  await fileIs("saved");

  // Nothing is wrong: that takes one line, and the drawing has the rest.
  await page.getByRole("tab", { name: /Problems/ }).click();
  await eventually(() => height("footer"), (found) => found < 40);
  await page.getByRole("tab", { name: "History" }).click();
  await eventually(() => height("footer"), about(168));

  // Borders are dragged; keys do the same through the commands.
  const left = await width("aside.left");
  await drag(".divider-left", 60, 0);
  await eventually(() => width("aside.left"), about(left + 60));
  const foot = await height("footer");
  await drag(".divider-foot", 0, -50);
  await eventually(() => height("footer"), about(foot + 50));
  const palette = await height(".palette");
  await drag(".divider-outline", 0, -40);
  await eventually(() => height(".palette"), about(palette + 40));
  await pick("first");
  const forms = await width("aside.right");
  await page.keyboard.press("Control+k");
  await answer("More room for the forms");
  await eventually(() => width("aside.right"), about(forms + 40));

  // Put away and brought back, by buttons and by keys; a reload remembers all of it.
  const main = await width("main");
  await button("Forms").click();
  await eventually(() => page.locator("aside.right").isVisible(), false);
  assert.ok((await width("main")) > main + 300);
  await page.keyboard.press("Control+b");
  await eventually(() => page.locator("aside.left").isVisible(), false);
  await check(page, "panes that are put away");
  await page.reload();
  await page.locator(".react-flow").first().waitFor();
  assert.equal(await page.locator("aside.left").isVisible(), false);
  assert.equal(await page.locator("aside.right").isVisible(), false);
  await button("Outline and palette").click();
  await eventually(() => width("aside.left"), about(left + 60));
  await button("Forms").click();
  await eventually(() => width("aside.right"), about(forms + 40));
  await page.keyboard.press("Control+k");
  await answer("Panes as they were at first");
  await eventually(() => width("aside.left"), about(left));

  // How it runs is one button, which says what isn't usual.
  const options = page.locator(".bar summary");
  await options.click();
  await page.getByLabel("Seed").fill("7");
  await choose("As", "sm");
  await check(page, "options of a run");
  await page.keyboard.press("Escape");
  await options.getByText("machine, seed 7").waitFor();

  // The robot in 3D as the main view.
  await button("3D").click();
  await page.getByText(/Loading|no robot|robot/i).first().waitFor();
  const view = page.getByRole("region", { name: "Robot in 3D" });
  await view.waitFor();
  await eventually(() => width(".robot-view"), about(await width(".stage")));
  await check(page, "3D as the main view");
  await view.getByRole("button", { name: "Close" }).click();
  await page.locator(".react-flow").first().waitFor();
});
