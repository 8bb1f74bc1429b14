// Large drawings. node scale.mjs URL FOLDER: at a distance few elements are there, a pan makes none of them anew, and what is
// sketched can be pressed. node scale.mjs URL FOLDER TASK... gives figures for people: each task unfolded, in each view, near and far.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder, ...tasks] = rest;
/** How long each motion is looked at for a figure [ms]. */
const LOOK = 2000;
const VIEWS = (process.env.VIEWS ?? "Tree,Flow").split(",");

const scaleOf = (page) => page.locator(".react-flow__viewport").evaluate((each) => new DOMMatrix(getComputedStyle(each).transform).a);

/** Go near or far with the wheel, as a person does. */
async function zoomTo(page, { x, y, width, height }, zoom) {
  await page.mouse.move(x + width / 2, y + height / 2);
  for (let steps = 0; steps < 200; steps++) {
    const now = await scaleOf(page);
    if (now >= zoom * 0.9 && now <= zoom * 1.1) break;
    await page.mouse.wheel(0, now < zoom ? -100 : 100);
  }
  let before = null;
  await eventually(() => scaleOf(page), (now) => now === before || ((before = now), false));
}

/** Open a task with all its containers; the whole of it is shown. */
async function unfold(page, { button, choose, answer }, task, view) {
  const name = task.replace(/^.*\/|\.yaml$/g, "");
  if (!(await page.title()).startsWith(name)) await choose("Task", task);
  await page.waitForFunction((name) => document.title.startsWith(name), name);
  await button(view).click();
  await page.keyboard.press("Control+k");
  await answer("Unfold everything");
  await page.getByRole("treeitem").nth(30).waitFor({ state: "attached" });
  await page.locator(view === "Flow" ? ".flow .react-flow" : ".react-flow:not(.flow *)").waitFor();
  // The chart of before stays until the new one is laid out: fitted again, it stays as it is.
  let last = [];
  await eventually(async () => {
    await page.locator('.flow[aria-busy="true"]').waitFor({ state: "detached" });
    await page.getByRole("button", { name: "Fit View" }).click();
    last = [...last, await scaleOf(page)].slice(-12);
    return last;
  }, (all) => all.length === 12 && new Set(all).size === 1);
  return page.locator(".react-flow").boundingBox();
}

/** Pan for a while, a step in every frame; returns the frames in a second. */
async function panned(page, { x, y, width, height }) {
  // A drag that begins at a node moves nothing.
  const [middle, top] = await page.evaluate(([x, y, width, height]) => {
    for (let at = 0; at < 400; at++) {
      const spot = [x + width * (0.5 + 0.04 * ((at % 20) - 10)), y + 40 + ((height - 80) * Math.floor(at / 20)) / 20];
      if (document.elementFromPoint(...spot)?.matches(".react-flow__pane, html, body")) return spot;
    }
    return [x + width / 2, y + 40];
  }, [x, y, width, height]);
  await page.mouse.move(middle, top);
  await page.mouse.down();
  // The steps are made in the page: a busy machine doesn't send moves as often as frames are drawn.
  const fps = await page.evaluate(
    ([middle, top, width, height, look]) =>
      new Promise((done) => {
        let [step, begun] = [0, 0];
        const next = (now) => {
          begun ||= now;
          if (now - begun >= look) return done((1000 * step) / (now - begun));
          step++;
          const at = { clientX: middle + (width / 3) * Math.sin(step / 20), clientY: top + (step % Math.round(height / 2)) };
          window.dispatchEvent(new MouseEvent("mousemove", { ...at, view: window, buttons: 1 }));
          requestAnimationFrame(next);
        };
        requestAnimationFrame(next);
      }),
    [middle, top, width, height, LOOK],
  );
  await page.mouse.up();
  return fps;
}

async function figures(page, words) {
  const empty = await page.context().newPage();
  await empty.goto("about:blank");
  for (const task of tasks) {
    for (const view of VIEWS) {
      await page.bringToFront();
      const begin = Date.now();
      const box = await unfold(page, words, task, view);
      const opened_ms = Date.now() - begin;
      const whole = await scaleOf(page);
      for (const [name, zoom] of [["near", 0.8], ["nearly read", 0.65], ["by name", 0.5], ["at a distance", 0.35], ["as a sketch", 0.25], ["far", 0.12], ["as a whole", whole]]) {
        if (zoom < whole) continue;
        await zoomTo(page, box, zoom);
        if (process.env.PICTURES) await page.screenshot({ path: join(process.env.PICTURES, `${task.replace(/^.*\/|\.yaml$/g, "")}-${view}-${name.replaceAll(" ", "_")}.png`) });
        await empty.bringToFront();
        const blank = await panned(empty, box);
        await page.bringToFront();
        const moved = await page.locator(".react-flow__viewport").getAttribute("style");
        const fps = await panned(page, box);
        assert.notEqual(await page.locator(".react-flow__viewport").getAttribute("style"), moved, "it has been moved");
        const [nodes, elements] = [await page.locator(".react-flow__node").count(), await page.locator(".react-flow *").count()];
        console.log(JSON.stringify({ task, view, name, zoom: Number((await scaleOf(page)).toPrecision(2)), fps: Math.round(10 * fps) / 10, empty: Math.round(10 * blank) / 10, ratio: Math.round((100 * fps) / blank) / 100, nodes, elements, opened_ms }));
      }
    }
  }
}

/** What changes on the page while the drawing is moved a little: everything but its place and the frame in the map. */
async function changedByPan(page, { x, y, width, height }) {
  // Away from a tile's edge: where the area in sight changes, its picture is made anew, once.
  await page.mouse.move(x + width / 2, y + 20);
  await page.mouse.down();
  await page.mouse.move(x + width / 2 + 3, y + 20);
  await page.evaluate(() => {
    window.changes = [];
    const own = (each) => each.matches(".react-flow__viewport, .frame");
    window.watch = new MutationObserver((all) => window.changes.push(...all.filter((each) => !own(each.target)).map((each) => `${each.type} of ${each.target.className?.baseVal ?? each.target.className}`)));
    window.watch.observe(document.querySelector(".react-flow"), { subtree: true, childList: true, attributes: true });
  });
  const before = await page.locator(".react-flow__viewport").getAttribute("style");
  for (let step = 1; step <= 10; step++) await page.mouse.move(x + width / 2 + 3 + step, y + 20 + step);
  await eventually(() => page.locator(".react-flow__viewport").getAttribute("style"), (now) => now !== before, "the drawing moves");
  const changes = await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(window.changes)))));
  await page.evaluate(() => window.watch.disconnect());
  await page.mouse.up();
  return changes;
}

async function facts(page, words) {
  const { button } = words;
  const selected = () => page.locator('[role="treeitem"][aria-selected="true"]').getAttribute("data-row");
  for (const view of ["Tree", "Flow"]) {
    const box = await unfold(page, words, "tasks/large.yaml", view);
    const nodes = () => page.locator(".react-flow__node").count();
    await eventually(nodes, (count) => count <= 2, "as a whole, only what is selected or pointed at is an element");
    await page.locator(".sketch").waitFor();
    await zoomTo(page, box, view === "Tree" ? 0.1 : 2 * (await scaleOf(page)));
    await eventually(nodes, (count) => count <= 2, "at a distance likewise");
    const found = [];
    for (let tries = 0; tries < 3; tries++) found.push(await changedByPan(page, box));
    assert.ok(found.some((changes) => changes.length === 0), `a pan makes something anew: ${JSON.stringify(found)}`);
    // A press on the sketch selects what it shows, and the outline goes there.
    for (let at = 0; at < 60 && (await selected()) === "/"; at++) await page.mouse.click(box.x + box.width / 2 - 60 + (at % 12) * 11, box.y + box.height / 2 - 8 + Math.floor(at / 12) * 4);
    await eventually(selected, (path) => path !== "/", "what is pressed is selected");
    await check(page, `${view}, sketched`);
    // The map leads elsewhere.
    const style = () => page.locator(".react-flow__viewport").getAttribute("style");
    const before = await style();
    await page.locator(".map").click({ position: { x: 70, y: 80 } });
    await eventually(style, (now) => now !== before, "the map leads there");
    // Nearer, nodes are elements again: those in sight, and what their edges lead to.
    for (const zoom of [0.12, 0.35, 1]) {
      await zoomTo(page, box, zoom);
      await eventually(nodes, (count) => count <= 100 && (count > 2 || zoom < 0.45), `at ${zoom}, few of ${view} are elements`);
    }
    // The chart of the whole task is what the next view begins with.
    await page.locator('[role="treeitem"][aria-selected="true"]').focus();
    await page.keyboard.press("Home");
    await eventually(selected, (path) => path === "/", "Home selects the root");
  }
  await button("Tree").click();
}

if (tasks.length === 0) {
  const group = (g) => `    g${g}:\n      kind: state_machine\n      initial: s0\n      outcomes: {success: success}\n      children:\n${Array.from({ length: 8 }, (_, s) => `        s${s}: {node: flow/wait, with: {seconds: 1}, on: {success: ${s < 7 ? `s${s + 1}` : "success"}}}`).join("\n")}`;
  writeFileSync(join(folder, "tasks/large.yaml"), `grip: 1\nname: large\nroot:\n  kind: parallel\n  children:\n${Array.from({ length: 60 }, (_, g) => group(g)).join("\n")}\n`);
}
await onPage(url, tasks.length > 0 ? figures : facts);
