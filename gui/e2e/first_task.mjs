// From an empty project to a pick that runs in simulation, by a person: robot, sensor, grasp service, poses, task, run, stop,
// replay. What the person does is counted; a key, a press, a choice or a typed answer is one.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { onPage, rest, url } from "./page.mjs";

const [folder] = rest;
const BUDGET = 80;
let actions = 0;

await onPage(url, async (page, { answer, button, nodeIs, runIsStopped, slider }) => {
  const press = async (name) => (actions++, button(name).first().click());
  const key = async (keys) => (actions++, page.keyboard.press(keys));
  const choose = async (label, value) => (actions++, page.getByLabel(label, { exact: true }).selectOption(value));
  const template = (title) => choose("Insert a template", title);
  const open = async (text) => (actions++, page.getByRole("button", { name: new RegExp(`^${text}`) }).click());
  const reply = async (text) => (actions++, answer(text));
  const fill = async (label, text, enter = false) => {
    actions++;
    await page.getByLabel(label, { exact: true }).fill(text);
    if (enter) await page.keyboard.press("Enter");
  };
  const fresh = async (port, name) => {
    await choose(port, "New variable ...");
    await reply(name);
    await page.getByLabel(port, { exact: true }).and(page.locator(`:has(option:checked[value="${name}"])`)).waitFor();
  };
  const row = (path) => page.locator(`[role="treeitem"][data-row="${path}"]`);
  const pick = async (path) => (actions++, row(path).click());
  const add = async (what, path) => {
    await key("/");
    await reply(what);
    await row(path).waitFor();
  };

  // The robot, a depth sensor, the world.
  await press("Project");
  await page.getByLabel("Insert a template").waitFor();
  await template("Panda with an Allegro hand");
  await template("an arm with a hand");
  await template("a hand");
  await template("a camera of the simulated world");
  await template("the simulated table");
  await page.getByText("not saved", { exact: true }).waitFor();
  await key("Control+s");
  await page.getByText("saved", { exact: true }).waitFor();
  await page.getByText("Nothing is wrong with it").waitFor();

  // The grasp service, generated.
  await open("New component");
  await fill("Interface", "antipodal_interfaces/srv/ProposeGrasps");
  await fill("Outcomes", "one,several,none");
  await fill("Failures", "none");
  await fill("Component", "antipodal_grasps");
  await fill("Server", "/propose_grasps");
  await page.getByText("It keeps the contract").waitFor();
  await press("Generate");
  await page.getByRole("main", { name: "Component", exact: true }).waitFor();
  await template("started by a command");
  await template("time-outs");
  await fill("Name of a new one in ports", "returned_object", true);
  const port = page.getByRole("group", { name: "ports returned_object" });
  actions++;
  await port.getByLabel("type", { exact: true }).fill("list[Grasp]");
  await page.keyboard.press("Enter");
  await page.getByText("Nothing is wrong with it").waitFor();
  await press("Generate the node");
  await page.getByLabel("Output of the command").getByText("manifest.yaml").waitFor();

  // Two poses, each where a robot is: the simulated one at its beginning, and the fake.
  await open("Message server");
  await choose("What", "the pose of its grasp frame");
  for (const [name, robot] of [["at_first", "a fresh simulation"], ["of_the_fake", "the fake"]]) {
    if (robot !== "a fresh simulation") await choose("Measured at", robot);
    actions++;
    await page.getByRole("group", { name: "Where the robot is" }).getByLabel("Name").fill(name);
    await press("Measure and save");
    await page.getByLabel("Result").getByText(`${name} was written into messages/poses.yaml`).waitFor();
  }
  assert.match(readFileSync(join(folder, "messages/poses.yaml"), "utf8"), /at_first:(.|\n)*of_the_fake:/);

  // The task: half of it as a tree. Variables are made where they are written first.
  await press("Tasks");
  await press("New task");
  await reply("clear_one");
  await row("/").waitFor();
  await pick("/");
  await add("hand/open", "open");
  await add("arm/move_to", "move_to");
  await fill("state str", "home", true);
  await pick("move_to");
  await add("sensor/overhead", "overhead");
  await fresh("points PointCloud", "cloud");
  await pick("overhead");
  await add("component/antipodal_grasps", "antipodal_grasps");
  await fresh("returned_object list[Grasp]", "grasps");
  await pick("antipodal_grasps");
  await add("grasp/choose", "choose");
  await fresh("grasp Grasp", "grasp");

  await pick("choose");
  await add("arm/place", "place");
  await fill("target str", "crate", true);

  // The other half as a flow chart.
  await pick("choose");
  await add("state machine", "state_machine");
  await press("Flow");
  await key("Enter");
  await add("arm/move_to_grasp", "state_machine/move_to_grasp");
  await add("hand/close", "state_machine/close");
  await add("arm/lift", "state_machine/lift");
  await press("Connect free outcomes");
  // A new machine begins with a state that does nothing; the checker says that the others aren't reached.
  await page.getByText("it is never reached").first().waitFor();
  await pick("state_machine");
  actions++;
  await page.getByLabel("Begins with").selectOption("move_to_grasp");
  await pick("state_machine/step");
  await key("Delete");
  await row("state_machine/step").waitFor({ state: "detached" });
  // What goes wrong is tried again.
  await press("Tree");
  await pick("state_machine");
  await key("w");
  await reply("retry");
  await row("retry/state_machine/lift").waitFor();
  if (process.env.LOOK) await page.screenshot({ path: process.env.LOOK });
  await page.getByText("No problems.").waitFor();

  // It runs, is stopped, and is looked at again.
  await press("Run");
  await nodeIs("choose", "success");
  await nodeIs("move_to_grasp", "running");
  await key("F8");
  await runIsStopped();
  await nodeIs("move_to_grasp", "interrupted");
  actions++;
  await slider().focus();
  await key("Home");
  await nodeIs("choose", "not started");
  await key("End");
  await nodeIs("choose", "success");
  assert.match(readFileSync(join(folder, "tasks/clear_one.yaml"), "utf8"), /node: arm\/place/);
  console.log(`${actions} actions`);
  assert.ok(actions <= BUDGET, `${actions} actions, of ${BUDGET}`);
});
