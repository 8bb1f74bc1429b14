// The user study's tasks from an empty project, as a person goes through them: what they do is counted, and how long the page takes for it.
// study.mjs URL FOLDER TASKS; beside the folder lies `lab`, which tests/gui/study_world.py wrote; STUDY_OUT is where pictures and transcripts go.
// With `keys` after them, all is done by keys alone, the keys are counted, and what a screen reader has to say at them is told.
import assert from "node:assert/strict";
import { appendFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { ear } from "./ear.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder, wanted, keys] = rest;
const out = process.env.STUDY_OUT;
const TITLES = {
  1: "a UR5 by its MoveIt package, between two recorded joint states",
  2: "TRAC-IK and BiTRRT, and the motion again",
  3: "a Shadow hand on a UR10 by a launch file, pick and place through recorded positions",
  4: "a Kinect 2 and a grasp algorithm from its own repository",
};
const BUDGETS = { 1: 12, 2: 6, 3: 35, 4: 40 };
const file = (path) => readFileSync(join(folder, path), "utf8");

/** A person at the page: does things, one action each, and says what they see. `hands` is how: by mouse and keys, or by keys alone. */
async function person(page, task) {
  const steps = [];
  const begun = performance.now();
  const heard = keys ? await ear(page) : null;
  const hands = heard ? keyboard(page, heard) : mouse(page);
  let waited = 0;
  async function act(words, work, until) {
    const start = performance.now();
    await work();
    if (until) await until();
    await hands.listen?.(steps.length + 1, words);
    const took = performance.now() - start;
    waited += took;
    steps.push({ words, seconds: took / 1000 });
    if (process.env.TELL) console.log(`${steps.length}. ${words} (${(took / 1000).toFixed(1)} s)${hands.pressed ? `, ${hands.pressed()} keys so far` : ""}`);
  }
  return {
    act,
    press: (words, what, until) => act(words, () => hands.press(what), until),
    /** Type into a field and press Enter. */
    fill: (words, what, text, until) => act(words, () => hands.fill(what, text), until),
    /** Move a slider. */
    slide: (words, what, value, until) => act(words, () => hands.slide(what, value), until),
    choose: (words, what, value, until) => act(words, () => hands.choose(what, value), until),
    /** Select a node in the outline. */
    select: (name, until) => act(`select ${name}`, () => hands.select(name), until),
    /** Move what lies in the world from above: by so much on the screen, held at a part of its width and height, or by an arrow key until `there`. */
    move: (words, what, by, part, arrow, there) => act(words, () => hands.move(what, by, part, arrow, there), () => there.waitFor()),
    key: (words, key, until) => act(words, () => hands.key(key), until),
    see: async (name, words) => {
      if (!out || keys) return;
      mkdirSync(out, { recursive: true });
      const shot = await page.screenshot();
      if (process.env.SHOTS) writeFileSync(join(out, `task${task}_${name}.png`), shot);
      writeFileSync(join(out, `task${task}_${name}.webp`), await small(page, shot));
      steps.push({ picture: `task${task}_${name}.webp`, words });
    },
    done: () => {
      const actions = steps.filter((step) => !step.picture).length;
      const budget = BUDGETS[task];
      const walk = { task, actions, budget, page_seconds: waited / 1000, seconds: (performance.now() - begun) / 1000, steps };
      console.log(JSON.stringify({ ...walk, steps: undefined, ...hands.counted?.() }));
      if (out && !keys) writeFileSync(join(out, `task${task}.md`), transcript(walk));
      assert.ok(actions <= budget, `task ${task}: ${actions} actions, of ${budget}`);
    },
  };
}

function mouse(page) {
  return {
    press: (what) => what.click(),
    fill: async (what, text) => (await what.fill(text), await what.press("Enter")),
    slide: (what, value) => what.fill(String(value)),
    choose: (what, value) => what.selectOption(value),
    select: (name) => page.getByRole("treeitem", { name: new RegExp(`^${name} `) }).click(),
    key: (key) => page.keyboard.press(key),
    move: async (what, [right, down], part) => {
      const box = await what.boundingBox();
      const [x, y] = [box.x + box.width * part, box.y + box.height * part];
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(x + right, y + down, { steps: 5 });
      await page.mouse.up();
    },
  };
}

/** Nothing but keys: the focus goes through the page by Tab and by F6, as a person without a mouse has to; who listens hears where it is. */
function keyboard(page, heard) {
  const counts = { keys: 0, tabs: 0, letters: 0 };
  const lines = [];
  /** What is said once it is still: at a key, or when something is done. */
  const note = async (keys) => {
    let now = await heard.spoken();
    for (let before = ""; before !== now; ) {
      before = now;
      await page.waitForTimeout(150);
      now = await heard.spoken();
    }
    lines.push(`${keys}: ${now}`);
  };
  const press = async (key) => {
    counts.keys++;
    if (/Tab$/.test(key)) counts.tabs++;
    await page.keyboard.press(key);
  };
  const type = async (text) => {
    counts.keys += text.length;
    counts.letters += text.length;
    await page.keyboard.type(text);
  };
  /** Where the focus is, seen from what is wanted. */
  const seen = (what) =>
    what.evaluate((element) => {
      const at = document.activeElement;
      if (at === element) return "there";
      return at && at !== document.body && at.compareDocumentPosition(element) & Node.DOCUMENT_POSITION_PRECEDING ? "before" : "after";
    });
  /** Go to something by Tab, back by Shift+Tab. */
  async function reach(what) {
    await what.waitFor();
    let last = "";
    for (let times = 0; times < 400; times++) {
      const where = await seen(what);
      if (where === "there") return void (last && (await note(`${last} ...`)));
      await press((last = where === "before" ? "Shift+Tab" : "Tab"));
    }
    assert.fail(`no number of Tabs leads to ${what}; the focus is on ${await page.evaluate(() => document.activeElement?.outerHTML.slice(0, 200))}`);
  }
  return {
    press: async (what) => (await reach(what), await press("Enter"), lines.push("Enter")),
    fill: async (what, text) => {
      await reach(what);
      await press("Control+a");
      await type(text);
      await note(`Ctrl+A, types ${text}`);
      await press("Enter");
      lines.push("Enter");
    },
    slide: async (what, value) => {
      await reach(what);
      for (let times = 0; times < 400; times++) {
        const now = Number(await what.inputValue());
        const step = Number(await what.getAttribute("step"));
        if (Math.abs(now - value) <= step / 2 + 1e-9) return void (await note("arrow keys"));
        await press(Math.abs(now - value) < 12 * step ? (now < value ? "ArrowRight" : "ArrowLeft") : now < value ? "PageUp" : "PageDown");
      }
    },
    /** A list of choices opens by a key; letters find in it, Enter takes. */
    choose: async (what, value) => {
      await reach(what);
      await press("Alt+ArrowDown");
      await type(value);
      await press("Enter");
      lines.push(`Alt+ArrowDown, types ${value}, Enter`);
    },
    select: async (name) => {
      const row = page.getByRole("treeitem", { name: new RegExp(`^${name} `) });
      const inTree = () => page.evaluate(() => document.activeElement?.getAttribute("role") === "treeitem");
      for (let times = 0; times < 12 && !(await inTree()); times++) await press("F6");
      await note("F6 ...");
      for (let times = 0; times < 100 && (await seen(row)) !== "there"; times++) await press((await seen(row)) === "before" ? "ArrowUp" : "ArrowDown");
      assert.equal(await seen(row), "there", `arrow keys lead to ${name}`);
      await note("arrow keys");
    },
    key: async (key) => (await press(key), lines.push(key.replace("Control", "Ctrl"))),
    move: async (what, _, __, arrow, there) => {
      await reach(what);
      for (let times = 0; times < 100 && (await there.count()) === 0; times++) {
        const before = await page.evaluate(() => document.activeElement?.getAttribute("aria-label"));
        await press(arrow);
        await eventually(() => page.evaluate(() => document.activeElement?.getAttribute("aria-label")), (now) => now !== before, `${arrow} moves it`);
      }
      await note(`${arrow} ...`);
    },
    /** When something is done: where the focus is then, and what live regions have told; of each, what was told last where it told much. */
    listen: async (number, words) => {
      await note("then");
      const told = (await heard.told()).map(([name, text]) => `  (${[name, text.replace(/process \d+/, "process ...")].filter(Boolean).join(": ")})`);
      const typed = Math.max(0, ...lines.map((line) => /types (.*?):/.exec(line)?.[1].length ?? 0));
      assert.ok(told.length <= 20 + typed, `${words}: who listens is told too much:\n${told.join("\n")}`);
      const last = told.filter((line, i) => !/^  \(\d+ entr/.test(line) || !/^  \(\d+ entr/.test(told[i + 1] ?? ""));
      console.log([`${number}. ${words}`, ...lines.splice(0).map((line) => `  ${line}`), ...last].join("\n"));
    },
    pressed: () => counts.keys,
    counted: () => counts,
  };
}

/** What was done, as a section of docs/study.md. */
function transcript({ task, actions, budget, page_seconds, steps }) {
  let number = 0;
  const lines = steps.map((step) => (step.picture ? `\n![${step.words}](pictures/study/${step.picture})\n` : `${++number}. ${step.words} (${step.seconds.toFixed(1)} s)`));
  return `## Task ${task}: ${TITLES[task]}\n\n**${actions} actions** of ${budget}; ${page_seconds.toFixed(0)} s of page, server and robot.\n\n${lines.join("\n").replace(/\n{3,}/g, "\n\n")}\n`;
}

/** A picture as WebP of at most 60 kB, made in a page of its own. */
async function small(page, png) {
  const beside = await page.context().newPage();
  for (let quality = 0.8; ; quality -= 0.1) {
    const coded = await beside.evaluate(
      async ([data, quality]) => {
        const image = new Image();
        image.src = `data:image/png;base64,${data}`;
        await image.decode();
        const canvas = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
        canvas.getContext("2d").drawImage(image, 0, 0);
        return canvas.toDataURL("image/webp", quality).split(",")[1];
      },
      [png.toString("base64"), quality],
    );
    const bytes = Buffer.from(coded, "base64");
    if (bytes.length > 60_000 && quality > 0.2) continue;
    await beside.close();
    return bytes;
  }
}

/** Go to a folder of this machine in the browser of files, and choose something there. */
async function browse(page, me, steps, last, until) {
  for (const step of steps) {
    await me.press(`open ${step}`, page.getByRole("listitem").getByRole("button", { name: new RegExp(`^${step}( ROS package| MoveIt configuration)?$`) }), () =>
      page.locator("[aria-current=location]").getByText(step, { exact: true }).waitFor());
  }
  await me.press(last.startsWith("Choose") ? last.replace("Choose", "choose") : `choose ${last}`, page.getByRole("button", { name: last }), until);
}

const door = (page, name) => page.getByRole("group", { name: "How to begin" }).getByRole("button", { name: new RegExp(`^${name}`) });

async function takeRobot(page, me, words, steps, last) {
  const { button } = words;
  await me.press("press Take a robot", door(page, "Take a robot"), () => page.getByLabel("Search the robots").waitFor());
  await me.press("press My files ...", button("My files ..."), () => page.getByRole("navigation", { name: "Folder" }).waitFor());
  await browse(page, me, steps, last, () => page.getByRole("application").waitFor());
  await me.see("robot", "The robot, before it is taken.");
  await me.press("press Take", page.locator(".start-take").getByRole("button"), () => page.getByRole("heading", { name: "The project is there" }).waitFor());
  await page.getByRole("application").waitFor();
}

/** Wait until a run that has just been asked for has ended well; the one before said so, too. */
async function ranAgain(page, { runIs }) {
  await page.getByLabel("State of the run").getByText("success: success", { exact: true }).waitFor({ state: "detached" });
  await runIs("success: success");
}

/** Have the simulator's referee contradict a success of a task that hasn't placed what there is. */
function judged(task) {
  appendFileSync(join(folder, "grip.yaml"), `goals: {${task}: placed == objects}\n`);
}

async function agreed(page) {
  assert.equal(await page.getByText(/referee disagrees/).count(), 0, "what was told to be placed is placed");
}

/** Where a frame's z points, and its roll, pitch and yaw, of a quaternion w x y z. */
function turn([w, x, y, z]) {
  const ahead = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
  const pitch = Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x))));
  const level = Math.abs(Math.abs(pitch) - Math.PI / 2) < 1e-3;
  const roll = level ? 2 * Math.atan2(x, w) : Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y));
  const yaw = level ? 0 : Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
  return { ahead, rpy: [roll, pitch, yaw].map((each) => each.toFixed(4)).join(", ") };
}

const numbers = (text) => text.split(",").map(Number);
const near = (text) => (found) => numbers(text).every((each, at) => Math.abs(each - found[at]) < 0.004);

const walks = {
  /** Integrate a UR5 with MoveIt, and move it between two recorded joint states. */
  async 1(page, words) {
    const me = await person(page, 1);
    await takeRobot(page, me, words, ["lab", "src"], "Choose the folder ur5_moveit_config");
    await me.slide("turn the shoulder", page.getByRole("slider", { name: "shoulder_pan_joint" }), -0.6);
    const name = page.getByLabel("Name for where manipulator is now");
    await me.fill("keep where it is now: `left`", name, "left", () => page.getByText("left is kept.").waitFor());
    await me.slide("turn the shoulder", page.getByRole("slider", { name: "shoulder_pan_joint" }), 1.2);
    await me.fill("keep that: `right`", name, "right", () => page.getByText("right is kept.").waitFor());
    await check(page, "positions are kept");
    await me.see("kept", "Two positions are kept.");
    await me.press("press New task through the kept positions", words.button("New task through the kept positions"), () => words.nodeIs("manipulator_right", "not started"));
    await me.press("press Run", words.button("Run"), () => words.runIs("success: success"));
    await words.nodeIs("manipulator_right", "success");
    await me.see("ran", "It has moved through both.");
    me.done();
  },
  /** The arm with the hand by their launch file; a can is picked and placed through kept positions. */
  async 3(page, words) {
    const me = await person(page, 3);
    const { button, nodeIs } = words;
    await takeRobot(page, me, words, ["lab", "src", "lab_bringup", "launch"], "ur10_shadow.launch.xml");
    // The laboratory's notes say where the hand takes the can: here they are what the first task says.
    const [x, y, z, ...turned] = /position: \[(.*?)\], quaternion: \[(.*?)\]/.exec(file("tasks/take.yaml")).slice(1).flatMap((each) => each.split(",").map(Number));
    const { ahead, rpy } = turn(turned);
    const from = (back, up, aside = 0) => [x - back * ahead[0], y - back * ahead[1] + aside, z - back * ahead[2] + up].map((each) => each.toFixed(3)).join(", ");
    const position = page.getByLabel("Position of hand");
    const name = page.getByLabel("Name for where arm is now");
    const keep = async (called, where) => {
      await me.fill(`put the hand at ${where}`, position, where, () => eventually(() => position.inputValue().then(numbers), near(where)));
      await me.fill(`keep it: \`${called}\``, name, called, () => page.getByText(`${called} is kept.`).waitFor());
    };
    await me.fill(`turn the hand: ${rpy}`, page.getByLabel("Orientation of hand"), rpy);
    await keep("before", from(0.1, 0));
    await keep("at_can", from(0, 0));
    await me.see("at_can", "The hand at the can, by numbers; the arm follows.");
    await keep("lifted", from(0, 0.12));
    await keep("in_tray", from(0, 0.005, -0.25));
    await keep("away", from(0.12, 0.005, -0.25));
    await check(page, "a hand is moved");
    await me.press("press New task through the kept positions", button("New task through the kept positions"), () => nodeIs("arm_away", "not started"));
    const add = async (after, node) => {
      await me.select(after);
      await me.key("press /", "/", () => page.getByRole("dialog").locator("input").waitFor());
      await me.fill(`type ${node}`, page.getByRole("dialog").locator("input"), node, () => page.getByLabel("What was done").getByText(`${node.split("/")[1]} was added to`).waitFor());
    };
    await add("arm_at_can", "hand/close");
    await add("arm_in_tray", "hand/open");
    await me.see("task", "The task: kept positions, and the hand closes and opens.");
    await me.press("press Project", button("Project"), () => page.getByRole("button", { name: /^World bench/ }).waitFor());
    await me.press("press World bench", page.getByRole("button", { name: /^World bench/ }), () => page.getByRole("group", { name: "The world from above" }).waitFor());
    await me.choose("insert a region to place into", page.getByLabel("Insert a template"), "a region to place into", () => page.getByRole("button", { name: /^tray at/ }).waitFor());
    const tray = page.getByRole("button", { name: /^tray at/ });
    const can = await page.getByRole("button", { name: /^can at/ }).boundingBox();
    const box = await tray.boundingBox();
    const scale = (await page.getByRole("button", { name: /^bench at/ }).locator("rect").boundingBox()).width / 1.2; // the bench is so wide [m]
    const aside = can.x + can.width / 2 + 0.25 * scale - (box.x + box.width / 2);
    await me.move("drag the tray to where the can shall stand", tray, [aside, 0], 0.25, aside < 0 ? "ArrowLeft" : "ArrowRight", page.getByRole("button", { name: keys ? /^tray at 0\.\d+, -0\.1[678]/ : /^tray at 0\.\d+, -0\.1[0-9]/ }));
    await check(page, "a world from above");
    await me.see("world", "The tray, put there by mouse.");
    await me.key("press Ctrl+S", "Control+s", () => words.fileIs("saved"));
    await me.press("press Tasks", button("Tasks"), () => button("Run").waitFor());
    judged("through");
    await me.press("press Run", button("Run"), () => words.runIs("success: success"));
    await agreed(page);
    await me.see("ran", "The can stands in the tray.");
    me.done();
  },
  /** A Kinect 2 by its topics, a grasp algorithm by its repository; a block that somebody has moved is found, taken and placed. */
  async 4(page, words) {
    const me = await person(page, 4);
    const { button, nodeIs } = words;
    const pressNamed = (name, until) => me.press(`press ${name}`, page.getByRole("button", { name: new RegExp(`^${name}`) }).first(), until);
    await me.press("press Take a robot", door(page, "Take a robot"), () => page.getByLabel("Search the robots").waitFor());
    await me.press("choose panda", page.getByRole("list", { name: "Ready-made robots" }).getByRole("button", { name: "panda The", exact: false }), () => page.getByRole("application").waitFor());
    await me.press("press Take", page.locator(".start-take").getByRole("button"), () => page.getByRole("heading", { name: "The project is there" }).waitFor());
    // The camera: what it publishes is picked from what is there, and looked at.
    await me.press("press Project", button("Project"), () => page.getByRole("button", { name: /^Topics/ }).waitFor());
    await pressNamed("Topics", async () => page.getByRole("list", { name: "Topics" }).getByText("/kinect2/qhd/image_color_rect").waitFor());
    await pressNamed("/kinect2/qhd/image_color_rect", () => button("Put the camera into grip.yaml").waitFor());
    await me.press("press Receive one message", button("Receive one message"), () => page.getByRole("status", { name: "Received message" }).getByRole("img").waitFor());
    await me.see("kinect", "The camera's picture, and its three topics.");
    await me.press("press Put the camera into grip.yaml", button("Put the camera into grip.yaml"), () => page.getByRole("group", { name: "sensors kinect2" }).waitFor());
    await me.key("press Ctrl+S", "Control+s", () => words.fileIs("saved"));
    // The algorithm: its service is found in its repository, with what serves it.
    await pressNamed("New component", () => button("In its repository ...").waitFor());
    await me.press("press In its repository ...", button("In its repository ..."), () => page.getByRole("navigation", { name: "Folder" }).waitFor());
    const into = (step) => me.press(`open ${step}`, page.getByRole("listitem").getByRole("button", { name: new RegExp(`^${step}( ROS package)?$`) }), () => page.locator("[aria-current=location]").getByText(step, { exact: true }).waitFor());
    await me.press("go up", page.getByRole("button", { name: ".. (one folder up)" }), () => page.getByRole("listitem").getByRole("button", { name: /^lab$/ }).waitFor());
    for (const step of ["lab", "planar_grasps", "srv"]) await into(step);
    await me.press("choose PlanGrasp.srv", button("PlanGrasp.srv"), () => page.getByText("grasp_server.py").waitFor());
    await check(page, "a component from its repository");
    await me.see("component", "The service, and what serves it.");
    await me.press("press Generate", button("Generate"), () => page.getByRole("main", { name: "Component", exact: true }).waitFor());
    await me.press("press Try it", button("Try it"), () => page.getByLabel("Output of the command").waitFor());
    await me.see("tried", "The component has been started, and has answered.");
    const node = `component/${/name: (\S+)/.exec(await page.locator(".edit-bar code").textContent().then((path) => file(path)))[1]}`;
    // The task: it looks with the Kinect, asks the algorithm where to grasp, and places the block.
    await me.press("press Tasks", button("Tasks"), () => button("Open the first task").waitFor());
    await me.press("press Open the first task", button("Open the first task"), () => nodeIs("held", "not started"));
    const dialog = page.getByRole("dialog").locator("input");
    const closed = () => page.getByRole("dialog").waitFor({ state: "detached" });
    await me.select("look");
    await me.press("press Change", page.getByRole("button", { name: "Change", exact: true }), () => dialog.waitFor());
    await me.fill("type sensor/kinect2", dialog, "sensor/kinect2", closed);
    const add = async (after, what) => {
      await me.select(after);
      await me.key("press /", "/", () => dialog.waitFor());
      await me.fill(`type ${what}`, dialog, what, closed);
    };
    await add("obstacles", node);
    await me.choose("its best_grasp goes to `place`", page.getByRole("combobox", { name: /^best_grasp/ }), "place");
    await add("held", "arm/place");
    await me.fill("target: tray", page.getByLabel(/^target/).first(), "tray");
    await me.see("task", "The algorithm's grasp is where the hand goes.");
    await me.press("press Project", button("Project"), () => page.getByRole("button", { name: /^World bench/ }).waitFor());
    await me.press("press World bench", page.getByRole("button", { name: /^World bench/ }), () => page.getByRole("group", { name: "The world from above" }).waitFor());
    await me.choose("insert a region to place into", page.getByLabel("Insert a template"), "a region to place into", () => page.getByRole("button", { name: /^tray at/ }).waitFor());
    await me.move("drag the block elsewhere", page.getByRole("button", { name: /^block at/ }), [30, -25], 0.5, "ArrowRight", page.getByRole("button", { name: /^block at (?!0\.45, 0\.10)/ }));
    await me.key("press Ctrl+S", "Control+s", () => words.fileIs("saved"));
    await me.press("press Tasks", button("Tasks"), () => button("Run").waitFor());
    judged("take");
    await me.press("press Run", button("Run"), () => words.runIs("success: success"));
    await agreed(page);
    await me.see("ran", "The block lies in the tray.");
    me.done();
  },
  /** Other kinematics, another planner, and the motion again. */
  async 2(page, words) {
    const me = await person(page, 2);
    const form = page.getByRole("group", { name: "Form" });
    const field = (label) => form.getByRole("group", { name: "arms manipulator" }).getByLabel(label, { exact: true });
    await me.press("press Project", words.button("Project"), () => field("planner").waitFor());
    await me.fill("planner: BiTRRT", field("planner"), "BiTRRT", () => form.getByText("Nothing is wrong").waitFor());
    await me.fill("kinematics: trac_ik", field("kinematics"), "trac_ik", () => eventually(() => field("kinematics").inputValue(), "trac_ik"));
    await me.see("fields", "Both fields.");
    await me.key("press Ctrl+S", "Control+s", () => words.fileIs("saved"));
    await me.press("press Tasks", words.button("Tasks"), () => words.button("Run").waitFor());
    await me.press("press Run", words.button("Run"), () => ranAgain(page, words));
    assert.match(file("grip.yaml"), /planner: BiTRRT, kinematics: trac_ik|planner: BiTRRT\n\s+kinematics: trac_ik/);
    me.done();
  },
};

await onPage(
  url,
  async (page, words) => {
    for (const task of wanted.split(",")) await walks[task](page, words);
  },
  { reducedMotion: "reduce" },
);
