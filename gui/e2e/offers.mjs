// What a node needs and isn't there is offered when the node is added, from an empty project: an arm, a hand, a component. What is
// offered is made, the node stands in the task then, and the task runs.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder] = rest;
const file = (path) => readFileSync(join(folder, path), "utf8");

await onPage(
  url,
  async (page, { answer, button, item, nodeIs, runIs, fileIs }) => {
    const lacks = (word) => page.getByRole("dialog").getByRole("heading", { name: `The project has no ${word} yet` });
    const add = async (what) => {
      await page.keyboard.press("/");
      await answer(what);
    };
    const shot = (name) => (process.env.SHOTS ? page.screenshot({ path: join(process.env.SHOTS, `offers-${name}.png`) }) : undefined);
    await button("an empty task").click();
    await answer("offers");
    await item("offers").waitFor();

    // No arm, and no robot: one is chosen, and the node comes into the task for which that was.
    await item("offers").focus();
    await add("arm/move_to");
    await lacks("arm").waitFor();
    await check(page, "question: no arm");
    await shot("no-arm");
    await answer("Choose a robot");
    await page.getByRole("list", { name: "Ready-made robots" }).getByRole("button", { name: /^ur5 / }).click();
    await button("Take ur5").click();
    await shot("robot");
    await button("Go on, and add arm/move_to").click();
    await item("move_to").waitFor();
    await page.getByLabel(/^state/).first().fill("home");
    await page.keyboard.press("Enter");
    await page.getByText("No problems.").waitFor();

    // An arm without a hand: which hand is asked, and both are put together.
    await item("move_to").focus();
    await add("hand/open");
    await lacks("hand").waitFor();
    await check(page, "question: no hand");
    await shot("no-hand");
    await answer("Add the robot's hand");
    await page.getByRole("dialog").getByRole("heading", { name: "Which hand?" }).waitFor();
    await answer("shadow_right");
    await item("open").waitFor();
    await eventually(() => file("grip.yaml"), (text) => /arm: ur5, hand: shadow_right|arm: ur5\n\s+hand: shadow_right/.test(text));

    // A component that isn't there: it is made of its repository, and comes into the task.
    await item("open").focus();
    await add("a new component");
    await button("In its repository ...").click();
    const into = (step) => page.getByRole("listitem").getByRole("button", { name: new RegExp(`^${step}( ROS package)?$`) });
    await page.getByRole("button", { name: ".. (one folder up)" }).click();
    for (const step of ["lab", "greeter", "srv"]) {
      await into(step).click();
      await page.locator("[aria-current=location]").getByText(step, { exact: true }).waitFor();
    }
    await button("Greet.srv").click();
    await page.getByText("greet_server.py").waitFor();
    await button("Generate").click();
    await button("Add it to the task").waitFor();
    await check(page, "a component is made for a task");
    await shot("component");
    await button("Add it to the task").click();
    await item("greeter_greet").waitFor();

    await page.getByText("No problems.").waitFor();
    await shot("task");
    await page.keyboard.press("Control+s");
    await fileIs("saved");
    await button("Run").click();
    await runIs("success: success");
    for (const [node, ended] of [["move_to", "success"], ["open", "success"], ["greeter_greet", "done \\(success\\)"]]) await nodeIs(node, ended);
    await shot("ran");
    assert.match(file("tasks/offers.yaml"), /component\/greeter_greet/);
  },
  { reducedMotion: "reduce" },
);
