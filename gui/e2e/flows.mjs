// Flow charts for people: node flows.mjs URL FOLDER TASK[:CONTAINER[:OPEN,OPEN]] ... draws each, counts what can be counted, and takes pictures.
import { mkdirSync } from "node:fs";
import { join } from "node:path";

import { measureFlow } from "../frontend/scripts/measure_flow.mjs";
import { onPage, rest, url } from "./page.mjs";

const [folder, ...charts] = rest;
mkdirSync(folder, { recursive: true });
const colorScheme = process.env.SCHEME ?? "light";
const [width, height] = (process.env.SIZE ?? "1280x720").split("x").map(Number);

/** Boxes, edges and words as the browser has drawn them, in units of the chart. */
function drawn() {
  const pane = document.querySelector(".flow .react-flow__viewport").getBoundingClientRect();
  const zoom = new DOMMatrix(getComputedStyle(document.querySelector(".flow .react-flow__viewport")).transform).a;
  const rect = (element) => {
    const box = element.getBoundingClientRect();
    return { x: (box.x - pane.x) / zoom, y: (box.y - pane.y) / zoom, width: box.width / zoom, height: box.height / zoom };
  };
  const nodes = [...document.querySelectorAll(".flow .react-flow__node")];
  const boxes = nodes.map((node) => ({ id: node.dataset.id, ...rect(node), parent: null }));
  const holds = (a, b) => a.id !== b.id && b.id.startsWith(a.id) && a.x <= b.x + 1 && a.y <= b.y + 1 && a.x + a.width >= b.x + b.width - 1 && a.y + a.height >= b.y + b.height - 1;
  for (const box of boxes) box.parent = boxes.filter((other) => holds(other, box)).sort((a, b) => b.id.length - a.id.length)[0]?.id ?? null;
  const labels = [...document.querySelectorAll(".flow .edge-label")].map((label) => ({ text: label.textContent, id: label.dataset.edge, ...rect(label) }));
  const edges = [...document.querySelectorAll(".flow .react-flow__edge")].map((edge) => {
    const path = edge.querySelector(".react-flow__edge-path");
    const length = path.getTotalLength();
    const count = Math.max(2, Math.ceil(length / 3));
    const sampled = () => Array.from({ length: count + 1 }, (_, i) => path.getPointAtLength((length * i) / count)).map(({ x, y }) => ({ x, y }));
    // Of level and upright pieces the corners are all; pieces that lie on each other at round corners aren't crossings.
    const numbers = (text) => text.trim().split(/[ ,]+/).map(Number);
    const cornered = () => [...path.getAttribute("d").matchAll(/([MLQ])([^MLQ]*)/g)].map(([, what, text]) => ({ what, at: numbers(text) })).filter(({ what }, i, all) => what !== "L" || all[i + 1]?.what !== "Q").map(({ at: [x, y] }) => ({ x, y }));
    const points = /[CHV]/.test(path.getAttribute("d")) ? sampled() : cornered();
    const [, source, target] = /from (.*) to (.*)/i.exec(edge.getAttribute("aria-label"));
    const outcome = edge.dataset.id.startsWith(`${source}.`) ? edge.dataset.id.slice(source.length + 1) : "";
    const port = [...(document.querySelector(`.flow [data-path="${source}"]`)?.querySelectorAll("[data-outcome], .port") ?? [])].find((each) => (each.dataset.outcome ?? each.firstChild?.textContent) === outcome);
    const meaning = edge.classList.contains("success") || port?.classList.contains("success") ? "success" : "";
    return { id: edge.dataset.id, source, target, meaning, points, label: null };
  });
  for (const label of labels) {
    const named = edges.filter((edge) => (label.id === undefined ? edge.id.endsWith(`.${label.text}`) || label.text.startsWith("again") : edge.id === label.id) && edge.label === null);
    const middle = { x: label.x + label.width / 2, y: label.y + label.height / 2 };
    const far = (edge) => Math.min(...edge.points.map((point) => Math.hypot(point.x - middle.x, point.y - middle.y)));
    const own = named.sort((a, b) => far(a) - far(b))[0];
    if (own) own.label = label;
  }
  return { boxes, edges };
}

await onPage(
  url,
  async (page, { button, choose }) => {
    const counts = [];
    for (const chart of charts) {
      const [task, container = "/", open = ""] = chart.split(":");
      await choose("Task", `tasks/${task}.yaml`);
      await page.locator(`[role=treeitem][data-row="/"]`).waitFor();
      await button("Tree").click();
      for (const row of container === "/" ? ["/"] : [container]) await page.locator(`[role=treeitem][data-row="${row}"]`).click();
      if (container !== "/") await page.keyboard.press("Enter");
      else await button("Flow").click();
      for (const path of open.split(",").filter(Boolean)) {
        await page.locator(`[role=treeitem][data-row="${path}"]`).click();
        await page.keyboard.press("Shift+Enter");
        await page.locator(`.flow [data-path^="${path}/"]`).first().waitFor({ state: "attached" });
      }
      await page.locator(".flow .react-flow__edge").first().waitFor({ state: "attached" });
      await page.waitForTimeout(700);
      await page.screenshot({ path: join(folder, `${chart.replaceAll(/[^a-z_0-9]+/g, "-")}.first.png`) });
      await page.getByRole("button", { name: "Fit View" }).click();
      await page.waitForTimeout(500);
      const of = await page.evaluate(drawn);
      counts.push({ chart: chart.split(":").slice(0, 2).join(":"), ...measureFlow(of), doubled: await page.evaluate(() => [...document.querySelectorAll(".flow .edge-label")].filter((label) => [...document.querySelectorAll(".flow .port")].some((port) => !port.firstElementChild?.classList.contains("hidden") && port.firstChild?.textContent === label.textContent)).length) });
      await page.screenshot({ path: join(folder, `${chart.replaceAll(/[^a-z_0-9]+/g, "-")}.png`) });
    }
    console.table(counts);
  },
  { viewport: { width, height }, colorScheme, reducedMotion: "reduce" },
);
