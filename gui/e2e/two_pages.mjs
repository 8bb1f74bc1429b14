// What one page starts, another sees at once, and may stop. Says RUNNING, then waits for the run's process to die.
import { onPage, PATIENCE, url, words } from "./page.mjs";

await onPage(url, async (first, one) => {
  const second = await first.context().newPage();
  second.setDefaultTimeout(PATIENCE);
  const two = words(second);
  await second.goto(url);
  await second.getByRole("tree").waitFor();
  await one.choose("Task", "tasks/long.yaml");
  await one.choose("Robot", "fake");
  await one.button("Run").click();
  await two.nodeIs("one", "running");
  console.log("RUNNING");
  await one.runIs("died");
  await two.runIs("died");
  await one.nodeIs("one", "interrupted");
  await first.getByRole("alert").getByText(/ended by signal 9/).waitFor();
});
