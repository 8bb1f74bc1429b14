// Every screen, from an empty folder on: nothing that axe can find violates WCAG 2.2 AA, in light and dark; and pictures for people,
// where a folder for them is given. node screens.mjs URL FOLDER ROBOTS [PICTURES]: FOLDER is the empty project that `grip edit` serves at URL,
// ROBOTS a folder with an arm.urdf. PARTS=theTask,theProject looks at these alone, of a project that has begun.
import assert from "node:assert/strict";
import { appendFileSync, existsSync, mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder, robots, pictures] = rest;
const SIZES = [[1920, 1080], [1280, 720]];
if (pictures) mkdirSync(pictures, { recursive: true });

await onPage(
  url,
  async (page, { answer, button, choose, fileIs, item, nodeIs, pick, runIs, runIsStopped }) => {
    let count = 0;
    const faults = [];
    /** Look at the page as it is. */
    async function look(name) {
      count++;
      for (const colorScheme of ["light", "dark"]) {
        await page.emulateMedia({ colorScheme });
        await check(page, `${colorScheme}, ${name}`).catch((fault) => faults.push(fault.message));
        if (!pictures) continue;
        for (const [width, height] of SIZES) {
          await page.setViewportSize({ width, height });
          await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 150)))));
          await page.screenshot({ path: join(pictures, `${String(count).padStart(2, "0")}_${name.replaceAll(/[^a-z0-9]+/gi, "_")}-${width}-${colorScheme}.png`) });
        }
      }
    }
    const door = (name) => page.getByRole("group", { name: "How to begin" }).getByRole("button", { name: new RegExp(`^${name}`) });
    const drawn = (name) => page.getByRole("application", name ? { name } : {}).waitFor();

    const parts = { beginning, theTask, theQuestions, theProject, theFaults, twoAtOnce };
    for (const part of process.env.PARTS?.split(",") ?? Object.keys(parts)) await parts[part]();
    assert.deepEqual(faults, []);

    async function beginning() {
      await door("Take a robot").waitFor();
      await look("doors");
      await door("Bring a task").click();
      await page.getByRole("group", { name: "May its code be run?" }).waitFor();
      await look("bring a task");
      await page.getByLabel("What it is").selectOption("grip");
      await page.getByRole("list", { name: /^What lies in/ }).waitFor();
      await look("bring a task of GRIP");
      await door("Open an example").click();
      await page.getByRole("list", { name: "Tasks of the example" }).getByText("reactive pick").waitFor();
      await look("examples");
      await door("Take a robot").click();
      await page.getByLabel("Search the robots").waitFor();
      await look("robots");
      await button("My files ...").click();
      for (const step of robots.split("/").filter(Boolean)) {
        const crumb = page.getByRole("navigation", { name: "Folder" }).getByRole("button", { name: step, exact: true });
        if ((await crumb.count()) > 0) await crumb.first().click();
        else await page.getByRole("button", { name: step, exact: true }).click();
        await page.locator("[aria-current=location]").getByText(step, { exact: true }).waitFor();
      }
      await page.getByRole("button", { name: "arm.urdf" }).click();
      await drawn(/2 joints/);
      await look("a robot from files");
      assert.equal(existsSync(join(folder, "grip.yaml")), false, "nothing is written before a robot is taken");
      await button("Ready-made").click();
      await page.getByLabel("Search the robots").fill("panda allegro");
      await page.getByRole("list", { name: "Ready-made robots" }).getByRole("button", { name: /^panda_allegro The/ }).click();
      await drawn(/^panda_allegro/);
      await look("a ready-made robot");
      await button("Take panda_allegro").click();
      await page.getByRole("heading", { name: "The project is there" }).waitFor();
      await drawn(/^panda_allegro/);
      await look("what was made");
    }

    async function theTask() {
      if (await button("Open the first task").count()) await button("Open the first task").click();
      await choose("Task", "tasks/take.yaml");
      await page.getByText("No problems.").waitFor();
      for (const view of ["Tree", "Flow", "Split", "Text", "3D"]) {
        await button(view).click();
        await page.locator({ Tree: ".react-flow", Flow: ".flow .react-flow", Split: ".flow .react-flow", Text: ".cm-content", "3D": ".robot-canvas canvas" }[view]).waitFor();
        await look(`task ${view}`);
      }
      await button("Tree").click();
      if ((await page.getByRole("application").count()) === 0) await button("Robot in 3D").click();
      await page.getByRole("treeitem").nth(2).click();
      await look("a leaf and its form");
      await page.locator(".bar summary").click();
      await look("options of the run");
      await choose("Pace", "0.25"); // or else it is over before it is held
      await page.keyboard.press("Escape");
      await button("Run").click();
      await page.getByLabel("State of the run").getByText(/^starting/).waitFor();
      await look("a run that starts");
      await runIs("running");
      await drawn(/^panda_allegro/); // a first task is opened with the robot beside it
      await page.getByRole("list", { name: "Legend" }).waitFor();
      await button("Pause").click();
      await runIs("paused");
      await look("a run that holds");
      await button("3D").click();
      await look("a run that holds, in 3D");
      await button("Resume").click();
      await page.getByRole("list", { name: "Legend" }).getByText(/ N$/).waitFor();
      await button("Pause").click();
      await look("a grasp, in 3D");
      if (await button("Hand").count()) await button("Hand").click();
      await look("a grasp, from nearby");
      await button("Flow").click();
      await look("a run in the flow");
      await button("Tree").click();
      await button("Resume").click();
      await page.getByLabel("State of the run").getByText(/^(success|failure)/).waitFor();
      await look("a run that ended");
      for (const name of await page.getByRole("tablist").getByRole("tab").allTextContents()) {
        await page.getByRole("tab", { name, exact: true }).click();
        await look(`below: ${name}`);
      }
      const slider = page.getByRole("slider", { name: "Moment of the run" });
      await page.getByRole("tab", { name: "Run", exact: true }).click();
      await slider.focus();
      await page.keyboard.press("PageDown");
      await look("a moment of a record");
      await button("3D").click();
      await look("a moment of a record in 3D");
      await button("Tree").click();
      await button("Edit the task").click();
      await button("Edit the task").waitFor({ state: "detached" });
    }

    async function theQuestions() {
      await button("Tree").click();
      const leaf = page.getByRole("treeitem").nth(2);
      for (const [key, what] of [["Control+k", "commands"], ["Control+f", "search"], ["/", "add"], ["F2", "rename"], ["k", "kinds"], ["w", "wrap"], ["Shift+K", "conversion"], ["Shift+E", "extract"], ["c", "connect"]]) {
        await (["k", "Shift+K", "Shift+E"].includes(key) ? page.getByRole("treeitem").nth(1) : leaf).click();
        await page.keyboard.press(key);
        const dialog = page.getByRole("dialog");
        if (!(await dialog.waitFor({ timeout: 8000 }).then(() => true, () => false))) {
          console.log(`no dialog: ${what}`);
          continue;
        }
        await look(`question: ${what}`);
        await page.keyboard.press("Escape");
        await dialog.waitFor({ state: "detached" });
      }
      await button("New task").click();
      await look("question: new task");
      await page.keyboard.press("Escape");
      await leaf.click();
      await page.keyboard.press("c");
      await page.getByRole("dialog").getByRole("heading", { name: /^Which outcome/ }).waitFor();
      await page.keyboard.type("success");
      await page.keyboard.press("Enter");
      await page.getByRole("dialog").getByRole("heading", { name: /leads to$/ }).waitFor();
      await look("question: where an outcome leads");
      await page.keyboard.press("Escape");
      await page.getByRole("treeitem").nth(0).click();
      for (const name of ["New variable", "New outcome"]) {
        await button(name).first().click();
        await page.getByRole("dialog").waitFor();
        await look(`question: ${name}`);
        await page.keyboard.press("Escape");
      }
      await page.locator(".actions summary").click();
      await look("further things to do with a node");
      await page.keyboard.press("Escape");
      await page.getByRole("treeitem").nth(1).click();
      await look("a container and its form");
      await page.getByRole("treeitem").nth(0).click();
      await look("the task and its form");
      await leaf.click();
      await page.keyboard.press("F9");
      await page.getByRole("tab", { name: "Breakpoints" }).click();
      await look("breakpoints");
      await leaf.click();
      await page.keyboard.press("F9");
    }

    async function theProject() {
      await button("Project").click();
      await page.getByRole("group", { name: "Form" }).waitFor();
      await look("project");
      await page.getByText("The robot in 3D").click();
      await drawn(/^panda_allegro/);
      await look("the robot in 3D");
      await button("Text").click();
      await look("a form beside its text");
      await button("Text").click();
      const files = page.getByRole("navigation", { name: "Files of the project" });
      const names = await files.getByRole("button").evaluateAll((all) => all.map((each) => each.firstChild.textContent));
      console.log(names.join(" | "));
      for (const name of names.slice(1)) {
        const file = files.getByRole("button", { name: new RegExp(`^${name}`) }).first();
        await file.click();
        await file.and(files.locator('[aria-current="page"]')).waitFor();
        await page.getByRole("main").waitFor();
        await page.getByText("Checking ...").waitFor({ state: "detached" });
        await page.getByText(/^Looking (at the ROS graph|for a server) \.\.\.$/).waitFor({ state: "detached" });
        if (/^World/.test(name)) {
          await page.getByRole("button", { name: /^See what/ }).first().click();
          await eventually(() => page.getByRole("img", { name: /^What the camera/ }).evaluate((image) => image.naturalWidth).catch(() => 0), (width) => width > 0);
        }
        await look(`project: ${name}`);
      }
      await theNames(files);
      await files.getByRole("button", { name: /^New component/ }).click();
      await button("In its repository ...").click();
      await page.getByRole("list", { name: /^What lies in/ }).waitFor();
      await look("an interface in its repository");
      await button("Pasted, or installed").click();
      await page.getByRole("textbox", { name: "Interface", exact: true }).fill("my_interfaces/srv/PlanGrasp");
      await page.getByLabel("Its .srv or .action").fill("sensor_msgs/PointCloud2 input\nsensor_msgs/Picture picture\n---\nint32 outcome\ngeometry_msgs/PoseStamped[] returned_object\n");
      await page.getByText(/the field 'picture'/).waitFor();
      await look("an interface with a wrong field");
      await button("Template").click();
      await page.getByText("It keeps the contract").waitFor();
      await look("an interface that is kept");
      await page.getByLabel("Component", { exact: true }).fill("seer");
      await button("Generate").click();
      await page.getByRole("main", { name: "Component", exact: true }).waitFor();
      await look("a component");
      await files.getByRole("button", { name: /^Robot, sensors/ }).click();
      await page.getByLabel("Insert a template").selectOption("an arm with a hand");
      await page.getByRole("list", { name: "Problems of the file" }).waitFor();
      await look("a file with faults");
      await files.getByRole("button", { name: /^Named poses/ }).click();
      await page.getByRole("dialog").waitFor();
      await look("question: what to do with what isn't saved");
      await page.keyboard.press("ArrowDown");
      await page.keyboard.press("Enter");
      await page.getByText("messages/poses.yaml").first().waitFor();
    }

    /** Named joint states, poses and trajectories, as files and on a server. */
    async function theNames(files) {
      mkdirSync(join(folder, "messages"), { recursive: true });
      const joints = [0, -0.4, 0, -2, 0, 1.8, 0.8].map((at, number) => `panda_joint${number + 1}: ${at}`).join(", ");
      writeFileSync(join(folder, "messages/joint_states.yaml"), `home: {${joints}}\naside: {${joints.replace("panda_joint1: 0", "panda_joint1: 1")}}\n`);
      writeFileSync(join(folder, "messages/poses.yaml"), "above: {reference_frame: world, position: {x: 0.5, y: 0.1, z: 0.4}, orientation: {r: 0, p: 1.57, y: 0}}\n");
      writeFileSync(join(folder, "messages/trajectories.yaml"), "wave:\n  - {name: home, interpolate_time: 0, pause_time: 0}\n  - {name: aside, interpolate_time: 2, pause_time: 0.5}\n");
      for (const name of ["Named joint states", "Named poses", "Named trajectories"]) {
        await files.getByRole("button", { name: new RegExp(`^${name}`) }).click();
        await page.getByRole("group", { name: /^entries / }).first().waitFor();
        if (name !== "Named trajectories") await drawn(/^panda_allegro/);
        if (name === "Named poses") await page.getByText("Save where the robot is now").click();
        await look(`${name}, some`);
      }
      await files.getByRole("button", { name: /^Message server/ }).click();
      await button("Serve the project's messages").click();
      await page.getByRole("list", { name: "Messages in poses" }).getByRole("button").first().click();
      await page.getByRole("group", { name: "Message above" }).waitFor();
      await look("a message of a server");
      await button("Delete above from poses").click();
      await look("question: delete a message");
      await page.keyboard.press("Escape");
      await button("Reset").click();
      await look("question: reset the server");
      await page.keyboard.press("Escape");
      await button("Stop serving").click();
      await files.getByRole("button", { name: /^Robot, sensors/ }).click();
      await button("Browse for components").click();
      await page.getByRole("dialog").getByRole("list").waitFor();
      await look("question: browse for a folder");
      await page.keyboard.press("Escape");
      // Somebody else writes the file while it is edited here.
      const doc = page.getByRole("group", { name: "Form" }).getByLabel("doc", { exact: true });
      await doc.fill("Mine.");
      await doc.press("Enter");
      await fileIs("not saved");
      appendFileSync(join(folder, "grip.yaml"), "# theirs\n");
      await page.keyboard.press("Control+s");
      await page.getByRole("dialog").getByText("Reload the file").waitFor();
      await look("question: changed elsewhere");
      await page.getByRole("dialog").getByRole("button", { name: "Reload the file" }).click();
      await fileIs("saved");
    }

    async function theFaults() {
      // A task with a node that nobody knows.
      await button("Tasks").click();
      await choose("Task", "tasks/take.yaml");
      await page.waitForFunction(() => document.title.startsWith("take"));
      await button("Text").click();
      await page.locator(".cm-content").click();
      await page.keyboard.press("Control+End");
      await page.keyboard.insertText("    odd: {node: no_such/thing}\n");
      await page.getByRole("treeitem", { name: /^odd / }).waitFor();
      await look("a text with a fault");
      await button("Tree").click();
      const problems = page.getByRole("tab", { name: /^Problems/ });
      if ((await problems.getAttribute("aria-selected")) !== "true") await problems.click();
      await page.getByRole("list", { name: "Problems of the task" }).waitFor();
      await look("a task with a fault");
      await button("Undo").click();
      await page.getByRole("treeitem", { name: /^odd / }).waitFor({ state: "detached" });
    }

    async function twoAtOnce() {
      const other = await page.context().newPage();
      await other.goto(page.url());
      await other.getByRole("tree").waitFor();
      await page.bringToFront();
      await page.getByRole("list", { name: "Who looks on" }).waitFor();
      await look("two look on");
      await page.getByRole("button", { name: /Change your name/ }).click();
      await look("question: your name");
      await page.keyboard.press("Escape");
      // Who has run something here is in control, and the other one takes over; else whoever runs something is.
      await other.getByRole("list", { name: "Who looks on" }).waitFor();
      const over = other.getByRole("button", { name: "Take over" });
      await ((await over.count()) > 0 ? over : other.getByRole("button", { name: "Run", exact: true })).click();
      await page.getByRole("button", { name: "Take over" }).waitFor();
      await look("another one is in control");
      await button("Run").click();
      if (await page.getByRole("dialog").waitFor({ timeout: 8000 }).then(() => true, () => false)) await look("question: another page is in control");
      await page.keyboard.press("Escape");
      await other.getByRole("button", { name: "STOP" }).click();
    }
  },
  // What isn't the name of an interface is refused (400), and the page says why.
  { reducedMotion: "reduce", expected: /status of 4(00|09)/, deviceScaleFactor: 1 },
);
