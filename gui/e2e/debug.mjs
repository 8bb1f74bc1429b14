// Breakpoints set on nodes, steps of each kind, run to and from a node, a node played by a script, a value looked at.
import { eventually, onPage, url } from "./page.mjs";

await onPage(url, async (page, { button, choose, nodeIs, pick, runIs, runIsStopped }) => {
  await choose("Task", "tasks/short.yaml");
  await choose("Robot", "fake");
  await pick("second");
  await page.keyboard.press("F9");
  await page.getByRole("treeitem", { name: /^second .*breakpoint before/ }).waitFor();

  await page.keyboard.press("Alt+r");
  await runIs("paused before attempts/second (breakpoint)");
  await nodeIs("broken", "failure.no_plan");
  await page.getByRole("treeitem", { name: /^second .*the run holds here/ }).waitFor();
  await page.keyboard.press("F10");
  await runIs("paused before machine");
  await page.keyboard.press("F11");
  await runIs("paused before machine/a");
  await page.keyboard.press("Shift+F11");
  await runIs("success: success");

  const reached = page.getByRole("row", { name: /reached/ });
  await reached.getByRole("button", { name: "2", exact: true }).click();
  await page.locator(".value-preview").getByText("2", { exact: true }).waitFor();

  // Only after this outcome, and only when the condition holds.
  await page.getByRole("tab", { name: "Breakpoints" }).click();
  await choose("When attempts/second holds", "after:success");
  await page.getByLabel("Condition at attempts/second").fill("reached == 1");
  await page.keyboard.press("Enter");
  await button("Run").click();
  await runIs("paused after attempts/second (breakpoint)");
  await button("Resume").click();
  await runIs("success: success");
  await page.getByRole("tab", { name: "Breakpoints" }).click();
  await button("Clear the breakpoint at attempts/second").click();
  await page.getByText("No breakpoints").waitFor();

  // What comes before is passed over; the page says by what.
  await pick("b");
  await page.keyboard.press("Control+F10");
  await runIs("paused before machine/b");
  await button("STOP").click();
  await runIsStopped();
  await page.getByRole("tab", { name: "Breakpoints" }).click();
  await pick("machine");
  await button("Run from here").click();
  await runIs("success: success");
  await nodeIs("attempts", "success");
  await nodeIs("second", "not started");

  // Another outcome is played.
  await page.getByRole("tab", { name: "Breakpoints" }).click();
  await pick("attempts");
  await page.getByLabel("attempts", { exact: true }).fill("failure.no_grasp");
  await button("Run").click();
  await runIs("failure: failure");
  await nodeIs("attempts", "failure.no_grasp");
  await eventually(() => button("Run").isEnabled(), true);
});
