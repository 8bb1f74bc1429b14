// Two pages: one holds control, the other looks on, may stop, and takes over; a reload keeps control. Each sees who looks on.
import { check } from "./axe.mjs";
import { eventually, onPage, url, words } from "./page.mjs";

await onPage(url, async (first, one) => {
  const second = await first.context().newPage();
  const two = words(second);
  await second.goto(url);
  await second.getByRole("tree").waitFor();
  const who = (page) => page.getByRole("list", { name: "Who looks on" });
  // They are numbered as their connections come, which needn't be the order in which they were opened.
  const called = async (page) => /Viewer \d/.exec(await who(page).getByRole("button", { name: /Change your name/ }).textContent())[0];
  const bob = await called(second);
  // A page behind another one gets little of a busy machine: the one that is looked at is in front.
  await first.bringToFront();
  const ann = await called(first);
  await one.choose("Task", "tasks/long.yaml");
  await one.choose("Robot", "fake");
  await one.button("Run").click();
  await first.getByLabel("Control", { exact: true }).getByText("You control").waitFor();
  await second.bringToFront();
  await two.runIs("running");
  await second.getByLabel("Control", { exact: true }).getByText(`${ann} controls`).waitFor();
  await who(second).getByText(`${ann}, controls; looks at tasks/long.yaml`).waitFor({ state: "attached" });
  await first.bringToFront();
  // The first one says who it is, by keys.
  await who(first).getByRole("button", { name: new RegExp(`^${ann} \\(you\\), controls`) }).focus();
  await first.keyboard.press("Enter");
  await one.answer("Ann Lee");
  await second.bringToFront();
  await who(second).getByText("Ann Lee, controls; looks at tasks/long.yaml").waitFor({ state: "attached" });
  await second.getByLabel("Control", { exact: true }).getByText("Ann Lee controls").waitFor();
  await check(second, "two look on");

  await two.button("Pause").click();
  await second.getByRole("dialog").getByText("Look on").click();
  await second.getByRole("alert").getByText("another page is in control").waitFor();
  await first.bringToFront();
  await one.runIs("running");
  await first.reload();
  await first.getByLabel("Control", { exact: true }).getByText("You control").waitFor();

  await second.bringToFront();
  await second.getByLabel("Control", { exact: true }).getByRole("button", { name: "Take over" }).click();
  await two.button("Pause").click();
  await first.bringToFront();
  await one.runIs("paused");
  await first.getByLabel("Control", { exact: true }).getByText(`${bob} controls`).waitFor();
  // The name is kept over the reload; while one looks at the project's files the other is told.
  await one.button("Project").click();
  await second.bringToFront();
  await who(second).getByText("Ann Lee; looks at the project's files").waitFor({ state: "attached" });
  await eventually(() => who(second).locator(".viewer-dot").evaluateAll((dots) => new Set(dots.map((dot) => dot.className)).size), 2);
  await first.bringToFront();
  await first.keyboard.press("F8");
  await second.bringToFront();
  await two.runIsStopped();
}, { reducedMotion: "reduce" });
