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
  async (page, { answer, button, fileIs, nodeIs, pick, runIs, runIsStopped }) => {
    const press = async (what) => (actions++, what.click());
    const has = page.getByRole("list", { name: "What the project has" });
    const shoot = async (name) => {
      if (process.env.SHOTS) await page.screenshot({ path: `${process.env.SHOTS}/${name}-light-1280.png` });
    };
    await press(page.getByRole("button", { name: /^Take a robot/ }));
    const robots = page.getByRole("list", { name: "Ready-made robots" }).getByRole("button");
    await eventually(() => robots.first().textContent(), (name) => /^panda/.test(name), "what can begin a task stands before hands alone");
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
    await dragInSpace(page);
    await button("Save").click();
    await fileIs("saved");
    assert.match(readFileSync(join(folder, "worlds/bench.yaml"), "utf8"), /block: \{model: block, at: \[0\.\d+, -?0\.\d+, 0\.\d+\]\}/);
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

/** The block is dragged in the world's 3D drawing: the numbers follow, Shift lifts it, Esc takes it back, and beside it the camera is turned. */
async function dragInSpace(page) {
  const drawing = page.getByRole("application", { name: /^panda/ });
  await drawing.scrollIntoViewIfNeeded();
  const { x: left, y: top, width, height } = await drawing.boundingBox();
  const pointed = () => drawing.getAttribute("data-pointed");
  let near = [left, top];
  async function toBlock() {
    await page.mouse.move(...near);
    for (let y = 0.3 * height; y < height && (await pointed()) !== "object block"; y += 10)
      for (let x = 0.2 * width; x < width && (await pointed()) !== "object block"; x += 7) {
        near = [left + x, top + y];
        await page.mouse.move(...near);
      }
    assert.equal(await pointed(), "object block");
    return near;
  }
  const at = async () => (await page.getByRole("group", { name: "Form" }).getByLabel("at", { exact: true }).evaluateAll((fields) => fields.map((field) => field.value))).join(" ");
  /** Drag the block so far on the screen; give the numbers that were there before. */
  async function drag(right, down, keys = () => undefined) {
    const before = await at();
    const [x, y] = await toBlock();
    assert.equal(await drawing.evaluate((canvas) => canvas.style.cursor), "grab");
    await page.mouse.down();
    await page.mouse.move(x + right, y + down, { steps: 4 });
    assert.equal(await drawing.evaluate((canvas) => canvas.style.cursor), "grabbing");
    await page.getByText(/^object block at /).waitFor();
    await keys();
    await page.mouse.up();
    near = [x + right, y + down];
    return before;
  }
  const before = await drag(20, 10);
  await eventually(at, (now) => now !== before);
  const level = await at();
  await page.keyboard.down("Shift");
  await drag(0, -20);
  await page.keyboard.up("Shift");
  const lifted = await eventually(at, (now) => now !== level);
  await drag(-20, 10, () => page.keyboard.press("Escape"));
  await page.getByText(/^object block at /).waitFor({ state: "detached" });
  await page.mouse.move(left + width - 8, top + height - 8);
  await eventually(pointed, "");
  const seen = await drawing.screenshot();
  await page.mouse.down();
  await page.mouse.move(left + width - 80, top + height - 8, { steps: 3 });
  await page.mouse.up();
  await eventually(async () => !(await drawing.screenshot()).equals(seen), true);
  assert.equal(await at(), lifted);
}
