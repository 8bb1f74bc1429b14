// A newcomer, from an empty folder to a hand that holds something: choose a robot, take it, open its first task, run it. Then
// what lacks is offered where it is missed. What the person does is counted. (screens.mjs looks behind the other doors.)
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder] = rest;
const BUDGET = 5;

// The first run. Four presses, and a fifth that runs it.
let actions = 0;
await onPage(
  url,
  async (page, { answer, button, nodeIs, pick, runIs, runIsStopped }) => {
    const press = async (what) => (actions++, what.click());
    const has = page.getByRole("list", { name: "What the project has" });
    const shoot = async (name) => {
      if (process.env.SHOTS) await page.screenshot({ path: `${process.env.SHOTS}/${name}-light-1280.png` });
    };
    await press(page.getByRole("button", { name: /^Take a robot/ }));
    await press(page.getByRole("list", { name: "Ready-made robots" }).getByRole("button", { name: "panda The", exact: false }));
    await press(button("Take panda"));
    await page.getByRole("heading", { name: "The project is there" }).waitFor();
    for (const part of [/Robot panda/, /Arms arm/, /Hands hand/, /Cameras and sensors overhead/, /World bench/, /Tasks first, take/]) await has.getByText(part).or(has.getByRole("listitem").filter({ hasText: part })).first().waitFor();
    await page.getByRole("application", { name: /^panda/ }).waitFor();
    await check(page, "what the project has");
    await shoot("made");
    await press(button("Open the first task"));
    await nodeIs("held", "not started");
    await page.getByText("No problems.").waitFor();
    await press(button("Run"));
    await runIs("success: success");
    await nodeIs("held", "success");
    assert.ok(actions <= BUDGET, `${actions} actions, of ${BUDGET}`);
    console.log(`${actions} actions`);
    // The hand holds it: the drawing says so in words, and the referee agrees.
    await page.locator(".robot-words summary").click();
    await page.getByLabel("The drawing in words").getByText(/held by hand/).waitFor();
    await shoot("held");

    // What goes wrong on purpose is chosen while the task runs, and the run's events tell it.
    await button("Run").click();
    await runIs("running");
    await button("Pause").click();
    await runIs("paused");
    await page.keyboard.press("Control+Alt+f");
    await answer("Dim the light");
    await button("Resume").click();
    await page.getByRole("tab", { name: "Run", exact: true }).click();
    await page.getByText(/from the page: light of everything/).first().waitFor();
    await button("STOP").click();
    await runIsStopped();

    // What isn't there is offered where it is missed: take the camera out, and add its node.
    await button("Project").click();
    await page.getByText("The robot in 3D").click();
    await page.getByRole("slider", { name: "panda_joint4" }).waitFor();
    await page.getByRole("application", { name: /^panda/ }).waitFor();
    await check(page, "robot");
    await shoot("robot");
    await page.getByRole("button", { name: "Remove overhead from sensors" }).click();
    await has.getByText("none yet").waitFor();
    await page.keyboard.press("Control+s");
    await eventually(() => readFileSync(join(folder, "grip.yaml"), "utf8"), (text) => !text.includes("sensors:"));
    await page.getByRole("button", { name: /^World bench/ }).click();
    await page.getByRole("button", { name: "See what overhead sees" }).click();
    const seen = page.getByRole("img", { name: /^What the camera overhead/ });
    await eventually(() => seen.evaluate((image) => image.naturalWidth).catch(() => 0), (width) => width > 0);
    await check(page, "world");
    await shoot("world");
    await button("Tasks").click();
    await button("Edit the task").click();
    await button("Edit the task").waitFor({ state: "detached" }); // the task is read again
    await pick("take");
    await page.keyboard.press("/");
    await answer("sensor/overhead");
    await page.getByRole("dialog").getByRole("heading", { name: "The project has no camera yet" }).waitFor();
    await check(page, "question: no camera");
    await answer("Add the robot's camera");
    await eventually(() => readFileSync(join(folder, "grip.yaml"), "utf8"), (text) => text.includes("overhead"));
    await page.getByRole("treeitem", { name: /^overhead / }).waitFor();
  },
  { reducedMotion: "reduce" },
);
