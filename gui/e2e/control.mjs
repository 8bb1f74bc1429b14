// Two pages: one holds control, the other looks on, may stop, and takes over; a reload keeps control.
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
  await two.runIs("running");
  await second.getByLabel("Control", { exact: true }).getByText("Another page controls, 2 look on").waitFor();
  await first.getByLabel("Control", { exact: true }).getByText("This page controls").waitFor();

  await two.button("Pause").click();
  await second.getByRole("dialog").getByText("Look on").click();
  await second.getByRole("alert").getByText("another page holds control").waitFor();
  await one.runIs("running");
  await first.reload();
  await first.getByLabel("Control", { exact: true }).getByText("This page controls").waitFor();

  await second.getByLabel("Control", { exact: true }).getByRole("button", { name: "Take over" }).click();
  await two.button("Pause").click();
  await one.runIs("paused");
  await first.getByLabel("Control", { exact: true }).getByText("Another page controls").waitFor();
  await first.keyboard.press("F8");
  await two.runIs("stopped");
});
