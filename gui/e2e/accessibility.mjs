// No violation of WCAG 2.2 AA that axe can find, in light and dark, before and after a run; the outline by keys alone.
import assert from "node:assert/strict";

import { check } from "./axe.mjs";
import { eventually, onPage, url } from "./page.mjs";

for (const colorScheme of ["light", "dark"]) {
  await onPage(
    url,
    async (page, { button, choose, item, nodeIs, pick, runIs }) => {
      await choose("Task", "tasks/short.yaml");
      await choose("Robot", "fake");
      await nodeIs("machine", "not started");
      await check(page, `${colorScheme}, before`);
      await pick("machine");
      for (const view of ["Flow", "Split", "Text"]) {
        await button(view).click();
        await page.locator({ Flow: ".flow .port", Split: ".react-flow", Text: ".cm-content" }[view]).first().waitFor();
        await check(page, `${colorScheme}, ${view}`);
      }
      // The panel that looks for words in the text has the page's colours: what it says can be read.
      await page.locator(".cm-content").focus();
      await page.keyboard.press("Control+f");
      const find = page.locator(".cm-search");
      await find.getByRole("button", { name: "next" }).waitFor();
      assert.deepEqual(await find.locator("button[name]:not([name=close])").evaluateAll((all) => all.map((each) => getComputedStyle(each).backgroundImage).filter((each) => each !== "none")), []);
      await check(page, `${colorScheme}, find in the text`);
      await page.keyboard.press("Escape");
      await find.waitFor({ state: "detached" });
      await button("Tree").click();
      await pick("second");
      await check(page, `${colorScheme}, form of a leaf`);
      // The names stand in the middle of their rows, the buttons of the zoom in one line, none of them cut off.
      const off = (selector, part) =>
        page.locator(selector).evaluateAll((all, part) => all.map((each) => {
          const middle = (box) => (box.top + box.bottom) / 2;
          return Math.round(Math.abs(middle(each.getBoundingClientRect()) - middle(each.querySelector(part).getBoundingClientRect())));
        }), part);
      assert.deepEqual([...new Set((await off('[role="treeitem"]', ".row-name")).filter((by) => by > 1))], [], "names are off the middle of their rows");
      const zoom = await page.locator(".react-flow__controls button").evaluateAll((all) => all.map((each) => each.getBoundingClientRect().toJSON()));
      assert.equal(new Set(zoom.map((each) => Math.round(each.top))).size, 1, JSON.stringify(zoom));
      assert.ok(zoom.length === 3 && zoom.every(({ width, height }) => width >= 24 && height >= 24), JSON.stringify(zoom));
      for (const tab of ["History", "Run", "Problems"]) {
        await page.getByRole("tab", { name: tab }).click();
        await check(page, `${colorScheme}, ${tab}`);
      }
      for (const key of ["/", "F2", "Control+k"]) {
        await item("second").focus();
        await page.keyboard.press(key);
        await page.getByRole("dialog").waitFor();
        await check(page, `${colorScheme}, dialog of ${key}`);
        await page.keyboard.press("Escape");
        await page.getByRole("dialog").waitFor({ state: "detached" });
        await eventually(() => page.evaluate(() => document.activeElement?.getAttribute("data-row")), "attempts/second");
      }
      await button("Run").click();
      await runIs("success: success");
      await nodeIs("machine", "done \\(success\\)");
      await check(page, `${colorScheme}, after`);

      const focused = () => page.evaluate(() => document.activeElement?.getAttribute("data-row"));
      await page.getByRole("treeitem").first().focus();
      await page.keyboard.press("ArrowDown");
      await eventually(focused, "first");
      await page.keyboard.press("End");
      await eventually(focused, "machine/b");
      await page.keyboard.press("ArrowLeft");
      await eventually(focused, "machine");
      await page.keyboard.press("ArrowLeft");
      await eventually(() => page.getByRole("treeitem", { name: /^machine/ }).getAttribute("aria-expanded"), "false");
      const panel = () => page.evaluate(() => document.activeElement?.closest(".panel, .bar")?.querySelector("h1, h2")?.textContent ?? "");
      const passed = [];
      const goOn = async (key) => {
        const before = await panel();
        await page.keyboard.press(key);
        return eventually(panel, (now) => now !== before);
      };
      do passed.push(await goOn("F6"));
      while (passed.at(-1) !== "Outline" && passed.length < 12);
      for (const name of ["Palette", "Node", "Outline"]) assert.ok(passed.includes(name), `${name} of ${passed}`);
      await goOn("Shift+F6");
      assert.equal(await goOn("F6"), "Outline");
      assert.equal(await focused(), "machine");
      assert.equal(await page.locator('[role="treeitem"][tabindex="0"]').count(), 1, "the tree is one tab stop");
    },
    { colorScheme, reducedMotion: "reduce" },
  );
}
