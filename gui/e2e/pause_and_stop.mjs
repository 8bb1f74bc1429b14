// Pause, resume and step a long run, then stop it; by button, and by key.
import { eventually, onPage, url } from "./page.mjs";

await onPage(url, async (page, { button, choose, nodeIs, runIs, runIsStopped }) => {
  await choose("Task", "tasks/long.yaml");
  await choose("Robot", "fake");
  await button("Run").click();
  await nodeIs("one", "running");
  await runIs("running");
  await eventually(() => button("Run").isDisabled(), true);

  await button("Pause").click();
  await runIs("paused");
  // The clock stands still: one more tick of two waits is one in which nothing ends.
  await button("Step").click();
  await runIs("paused");
  await nodeIs("one", "running");
  await button("Resume").click();
  await runIs("running");

  await button("STOP").click();
  await runIsStopped();
  await nodeIs("one", "interrupted");
  await nodeIs("two", "interrupted");

  await button("Run").click();
  await nodeIs("one", "running");
  await page.keyboard.press("F8");
  await runIsStopped();
});
