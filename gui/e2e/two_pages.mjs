// What one page starts, another sees at once, and may stop. Says RUNNING, then waits for the run's process to die.
import { onPage, url, words } from "./page.mjs";

await onPage(url, async (first, one) => {
  const second = await first.context().newPage();
  const two = words(second);
  await second.goto(url);
  await second.getByRole("tree").waitFor();
  // A page behind another one gets little of a busy machine: the one that is looked at is in front.
  await first.bringToFront();
  await one.choose("Task", "tasks/long.yaml");
  await one.choose("Robot", "fake");
  await one.button("Run").click();
  await second.bringToFront();
  await two.nodeIs("one", "running");
  console.log("RUNNING");
  await two.runIs("error");
  await first.bringToFront();
  await one.runIs("error");
  await one.nodeIs("one", "interrupted");
  await first.getByRole("alert").getByText(/ended by SIGKILL/).waitFor();
}, { reducedMotion: "reduce" });
