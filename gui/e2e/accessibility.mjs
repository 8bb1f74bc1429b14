// No violation of WCAG 2.2 AA that axe can find, in light and dark, before and after a run; the outline by keys alone.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

import { onPage, url } from "./page.mjs";

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

async function check(page, where) {
  await page.evaluate(AXE);
  const { violations } = await page.evaluate((tags) => window.axe.run({ runOnly: tags }), TAGS);
  const words = violations.map((v) => `${where}: ${v.id}: ${v.help}\n  ${v.nodes.map((n) => n.html).join("\n  ")}`);
  assert.equal(violations.length, 0, words.join("\n"));
}

for (const colorScheme of ["light", "dark"]) {
  await onPage(
    url,
    async (page, { button, choose, nodeIs, runIs }) => {
      await choose("Task", "tasks/short.yaml");
      await choose("Robot", "fake");
      await nodeIs("machine", "not started");
      await check(page, `${colorScheme}, before`);
      await button("Run").click();
      await runIs("success: success");
      await nodeIs("machine", "done \\(success\\)");
      await check(page, `${colorScheme}, after`);

      const focused = () => page.evaluate(() => document.activeElement?.getAttribute("data-row"));
      await page.getByRole("treeitem").first().focus();
      await page.keyboard.press("ArrowDown");
      assert.equal(await focused(), "first");
      await page.keyboard.press("End");
      assert.equal(await focused(), "machine/b");
      await page.keyboard.press("ArrowLeft");
      assert.equal(await focused(), "machine");
      await page.keyboard.press("ArrowLeft");
      assert.equal(await page.getByRole("treeitem", { name: /^machine/ }).getAttribute("aria-expanded"), "false");
      assert.equal(await page.locator('[role="treeitem"][tabindex="0"]').count(), 1, "the tree is one tab stop");
    },
    { colorScheme, reducedMotion: "reduce" },
  );
}
