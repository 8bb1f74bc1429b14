// What is selected stays in sight when panes beside a drawing or the text come and go.
import { writeFileSync } from "node:fs";
import { join } from "node:path";

import { eventually, onPage, rest, url } from "./page.mjs";

const [folder] = rest;
const WORDS = "a message that goes on and on, so that its line is wrapped where the pane of the text is narrow, and wrapped again";
const leaf = (name) => `            ${name}: {node: flow/log, with: {message: "${WORDS}"}}`;
const group = (g) => `    g${g}:\n      kind: sequence\n      children:\n        h${g}:\n          kind: sequence\n          children:\n${["a", "b", "c", "d"].map((l) => leaf(`${l}${g}`)).join("\n")}`;
writeFileSync(
  join(folder, "tasks/wide.yaml"),
  `grip: 1\nname: wide\nroot:\n  kind: sequence\n  children:\n${Array.from({ length: 8 }, (_, g) => group(g)).join("\n")}\n`,
);

const PANES = { tree: ".react-flow:not(.flow *)", flow: ".flow .react-flow", text: ".cm-scroller" };

await onPage(url, async (page, { button, choose, fileIs, pick }) => {
  /** Where the selected node is in a pane: null while it is wholly in sight. */
  const lost = (name) =>
    page.evaluate(
      ([name, selector]) => {
        const selected = document.querySelector('[role="treeitem"][aria-selected="true"]')?.dataset.row;
        const pane = document.querySelector(selector)?.getBoundingClientRect();
        const box = name === "text" ? document.querySelector(".cm-node-line") : document.querySelector(`${selector} [data-path="${selected}"]`)?.closest(".react-flow__node");
        if (!pane || !box) return `${selected} isn't in the ${name}`;
        const { left, right, top, bottom } = box.getBoundingClientRect();
        const beside = name !== "text" && (left < pane.left - 1 || right > pane.right + 1);
        return beside || top < pane.top - 1 || bottom > pane.bottom + 1 ? `${selected} is out of sight in the ${name}: ${JSON.stringify({ left, right, top, bottom, pane })}` : null;
      },
      [name, PANES[name]],
    );
  const seen = async (...panes) => {
    for (const name of panes) await eventually(() => lost(name), null, `after a pane came or went, in the ${name}`);
  };

  await choose("Task", "tasks/wide.yaml");
  await fileIs("saved");
  for (const [name, beside] of [["a0", true], ["d7", true], ["wide", false], ["h3", true]]) {
    const charts = beside ? ["tree", "flow"] : ["tree"]; // the container that a chart shows isn't a box of it
    await button("Tree").click();
    await pick(name);
    await button("Split").click(); // while the tree is still moving there
    await seen(...charts);
    await button("Robot in 3D").click();
    await page.locator(".stage-robot").waitFor();
    await seen(...charts);
    await button("Close").click();
    await seen(...charts);
    await button("Flow").click();
    await seen(...charts.slice(1));
  }

  // A narrow pane has no map in its corner, which would hide most of it.
  await button("Tree").click();
  const map = page.locator(".map");
  await map.waitFor();
  const { height } = await map.boundingBox();
  if (height > 100) throw new Error(`the map is ${height} px high, and says nothing in most of them`);
  await button("Split").click();
  await map.waitFor({ state: "detached" });

  for (const name of ["d7", "wide", "a5", "c3"]) {
    await button("Text").click();
    await pick(name);
    await seen("text");
    await button("Split").click();
    await choose("Beside the tree", "text");
    await seen("tree", "text");
    await button("Robot in 3D").click();
    await page.locator(".stage-robot").waitFor();
    await seen("tree", "text");
    await button("Close").click();
    await seen("tree", "text");
  }

  // Where the text is no task any more a note comes above it: the line that is typed in isn't pushed out of sight.
  await button("Text").click();
  await pick("g4");
  const line = page.locator(".cm-line", { hasText: /^ +g4:$/ });
  await line.evaluate((each) => each.scrollIntoView({ block: "end" }));
  await line.click();
  await page.keyboard.press("End");
  await page.keyboard.type(" oops: - ");
  await fileIs("text isn't a task");
  await page.locator(".text-pane .stale-note").waitFor();
  const hidden = () =>
    page.evaluate(() => {
      const { bottom } = document.querySelector(".cm-activeLine").getBoundingClientRect();
      return bottom > document.querySelector(".cm-scroller").getBoundingClientRect().bottom + 1;
    });
  await eventually(hidden, false, "the line that is typed in is out of sight");
});
