// Each page of the project's files: the form and the text are one, a mistake is marked at its field and in the text with its
// reason, it is mended, saved, and the file on the disk is what it should be.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder] = rest;
const SEER = readFileSync(join(folder, "components/seer/component.yaml"), "utf8");
const file = (path) => readFileSync(join(folder, path), "utf8");

await onPage(url, async (page, { button, fileIs }) => {
  const form = page.getByRole("group", { name: "Form" });
  const text = page.getByLabel("Text of the file");
  const found = page.getByRole("list", { name: "Problems of the file" });
  const within = (names) => names.reduce((at, name) => at.getByRole("group", { name, exact: true }), form);
  /** A field by the groups around it and its label. */
  const field = (...names) => within(names.slice(0, -1)).getByLabel(names.at(-1), { exact: true });
  const put = async (names, value) => {
    await field(...names).fill(value);
    await field(...names).press("Enter");
  };
  const open = (title) => page.getByRole("navigation").getByRole("button", { name: new RegExp(`^${title}`) }).click();
  const template = (title) => page.getByLabel("Insert a template").selectOption(title);
  const fine = () => form.getByText("Nothing is wrong with it").waitFor();
  /** What the text pane shows. */
  const shown = () => text.evaluate((pane) => [...pane.querySelectorAll(".cm-line")].map((line) => line.textContent).join("\n"));

  /** Make a mistake in a field, see it marked at the field, in the list and in the text, and mend it by typing into the text. */
  async function mistake(names, wrong, right, reason, invalid = "true") {
    await put(names, wrong);
    await found.getByText(reason).waitFor();
    const about = await field(...names).getAttribute("aria-describedby");
    await eventually(() => form.locator(`[id="${about}"]`).textContent(), (said) => reason.test(said), "the field says why");
    await eventually(() => field(...names).getAttribute("aria-invalid"), invalid);
    await page.locator(".cm-lintRange-error, .cm-lintRange-warning").first().waitFor();
    // The line is found from the list, and mended by hand: what is wrong stands there as it was typed.
    await found.getByRole("button").first().click();
    await eventually(() => text.evaluate((pane) => pane.contains(document.activeElement) || pane === document.activeElement), true);
    const before = await shown();
    assert.ok(before.includes(wrong), `the text has what was typed into the field: ${before}`);
    await page.keyboard.press("Control+a");
    await page.keyboard.insertText(before.replace(wrong, right));
    await fine();
    await eventually(() => field(...names).inputValue(), right, "the field has what was typed into the text");
    await eventually(() => field(...names).getAttribute("aria-invalid"), "false");
  }

  async function saved(path, wanted) {
    await page.keyboard.press("Control+s");
    await fileIs("saved");
    assert.equal(file(path), wanted);
  }

  // The robot, its arms and hands, and how they plan.
  await button("Project").click();
  await field("robot").waitFor();
  await button("Text").click();
  await template("an arm with a hand");
  await template("a hand");
  await fine();
  await mistake(["robot"], "panda_alegro", "panda_allegro", /did you mean 'panda_allegro'/);
  const arm = ["arms", "arms right"];
  await mistake([...arm, "planner"], "RRTConect", "BiTRRT", /did you mean 'RRTConnect'/);
  await mistake([...arm, "kinematics"], "trac_ikk", "trac_ik", /did you mean 'trac_ik'/);
  await mistake([...arm, "attempts"], "many", "12", /a valid integer/);
  await check(page, "robot and planners");

  // A sensor on topics.
  await template("a depth sensor on topics");
  const cloud = ["sensors", "sensors depth", "topics", "topics cloud"];
  await mistake([...cloud, "topic"], "camera points", "/camera/points", /isn't a whole ROS name/);
  await mistake([...cloud, "type"], "PointClud", "PointCloud", /did you mean 'PointCloud'/);
  await check(page, "sensors");
  if (process.env.LOOK) await page.screenshot({ path: process.env.LOOK });
  await saved(
    "grip.yaml",
    `grip: 1
# the one in the lab
robot: panda_allegro
arms:
  right:
    group: arm
    hand: right_hand
    planner: BiTRRT
    kinematics: trac_ik
    attempts: 12
hands:
  right_hand:
    group: hand
sensors:
  depth:
    topics:
      cloud:
        topic: /camera/points
        type: PointCloud
`,
  );

  // What is a path is browsed for.
  await button("Browse for nodes").click();
  await page.getByRole("dialog").getByRole("button", { name: "Choose the folder nodes" }).waitFor();
  await check(page, "browsing for a folder");
  await page.keyboard.type("no");
  await eventually(() => page.evaluate(() => document.activeElement.textContent.trim()), "nodes");
  await page.getByRole("dialog").getByRole("button", { name: "Choose the folder nodes" }).click();
  await eventually(() => field("nodes").inputValue(), "nodes");
  await put(["nodes"], "");
  await fileIs("saved");

  // An external component.
  await open("Component seer");
  await fine();
  await template("time-outs");
  await mistake(["timeouts", "call"], "soon", "30.5", /a valid number/);
  await mistake(["meaning", "meaning none", "none"], "failur", "failure", /should be 'success' or 'failure'/);
  await check(page, "a component");
  await saved("components/seer/component.yaml", `${SEER}timeouts:\n  call: 30.5\n  ready: 60\n`);

  // Named joint states: a number, and a joint that the robot doesn't have, which is pointed out.
  await open("Named joint states");
  await template("a joint state of arm");
  await template("a joint state of arm");
  await put(["entries", "Name of home_2 in entries"], "above");
  await fine();
  await mistake(["entries above", "above", "above panda_joint1", "panda joint1"], "left", "0.25", /a valid number, not 'left'/);
  const right = await shown();
  await text.click();
  await page.keyboard.press("Control+a");
  await page.keyboard.insertText(right.replace("panda_joint7", "panda_jont7"));
  await found.getByText("maybe: home/panda_jont7: the robot has no joint 'panda_jont7'; did you mean 'panda_joint7'?").waitFor();
  await check(page, "a doubt");
  await page.keyboard.press("Control+a");
  await page.keyboard.insertText(right);
  await fine();
  // The robot goes where a picture of one is pressed.
  const picture = page.getByRole("group", { name: "Named joint states" }).getByRole("button", { name: "above" });
  await picture.click();
  await eventually(() => picture.getAttribute("aria-pressed"), "true");
  await check(page, "joint states in 3D");
  await saved("messages/joint_states.yaml", right);
  assert.match(right, /\nabove:\n  panda_joint1: 0\.25\n  panda_joint2: -?[0-9.]+\n/);

  // Named poses.
  await open("Named poses");
  await template("a pose");
  await mistake(["entries above_table", "position", "x"], "left", "0.55", /a valid number, not 'left'/);
  await mistake(["entries above_table", "reference frame"], "wrld", "world", /the robot has no frame 'wrld'; did you mean 'world'/, "false");
  await page.getByRole("application", { name: /^panda_allegro/ }).waitFor();
  await check(page, "poses");
  await saved("messages/poses.yaml", `above_table:
  reference_frame: world
  position:
    x: 0.55
    y: 0
    z: 0.4
  orientation:
    r: 0
    p: 0
    y: 0
`);

  // Named trajectories, through joint states that there are.
  await open("Named trajectories");
  await template("a way through joint states");
  await fine();
  const second = ["entries approach", "approach 2"];
  await mistake([...second, "name"], "abov", "above", /there is no 'abov'; did you mean 'above'/);
  await mistake([...second, "interpolate time"], "soon", "2.5", /a valid number, not 'soon'/);
  await check(page, "trajectories");
  await saved("messages/trajectories.yaml", `approach:
  - name: home
    interpolate_time: 2
    pause_time: 0
  - name: above
    interpolate_time: 2.5
    pause_time: 0
`);

  // A file that isn't saved isn't left unasked.
  await put([...second, "interpolate time"], "3.5");
  await page.getByText("not saved", { exact: true }).waitFor();
  await open("Named poses");
  await page.getByRole("dialog").getByText("messages/trajectories.yaml isn't saved").waitFor();
  await page.keyboard.press("Escape");
  await fileIs("not saved");
});
