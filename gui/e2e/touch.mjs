// Watching a run by touch on a small screen that asks for calm: pan, pinch, and STOP under the thumb; then on a phone.
import assert from "node:assert/strict";

import { check } from "./axe.mjs";
import { eventually, onPage, url } from "./page.mjs";

await onPage(
  url,
  async (page, { button, choose, nodeIs, runIsStopped }) => {
    await choose("Task", "tasks/long.yaml");
    await choose("Robot", "fake");
    await button("Run").tap();
    await nodeIs("one", "running");

    // Nothing lies outside of the screen, and nothing over STOP.
    const size = await page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]);
    assert.deepEqual(size, [1280, 720]);
    const stop = await button("STOP").boundingBox();
    assert.ok(stop.x >= 0 && stop.y >= 0 && stop.x + stop.width <= 1280 && stop.y + stop.height <= 720, "STOP is in sight");
    assert.ok(stop.width >= 44 && stop.height >= 24, "STOP is large enough for a thumb");

    // The spinner of a running node stands still.
    assert.equal(await page.locator(".react-flow .spin").first().evaluate((mark) => getComputedStyle(mark).animationName), "none");

    const touch = await page.context().newCDPSession(page);
    const fingers = (type, ...points) => touch.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    const view = () =>
      page.locator(".react-flow__viewport").evaluate((element) => {
        const { a, e, f } = new DOMMatrix(getComputedStyle(element).transform);
        return { zoom: a, x: e, y: f };
      });
    const box = await page.locator(".react-flow").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height - 60];

    let seen = null;
    const stands = (now) => JSON.stringify(now) === JSON.stringify(seen) || ((seen = now), false);
    const before = await eventually(view, stands);
    await fingers("touchStart", [x, y]);
    for (let step = 1; step <= 8; step++) await fingers("touchMove", [x - 10 * step, y - 5 * step]);
    await fingers("touchEnd");
    await eventually(view, (now) => now.x < before.x - 40 && now.y < before.y - 20, "one finger moves the drawing");
    const panned = await eventually(view, stands);
    assert.equal(panned.zoom, before.zoom);

    await fingers("touchStart", [x - 20, y], [x + 20, y]);
    for (let step = 1; step <= 8; step++) await fingers("touchMove", [x - 20 + 2 * step, y], [x + 20 - 2 * step, y]);
    await fingers("touchEnd");
    await eventually(view, (now) => now.zoom < panned.zoom, "two fingers zoom");

    await button("STOP").tap();
    await runIsStopped();
    await nodeIs("one", "interrupted");
    if (process.env.PICTURE) await page.screenshot({ path: process.env.PICTURE });
  },
  { hasTouch: true, reducedMotion: "reduce" },
);

await onPage(
  url,
  async (page, { button, choose, nodeIs, runIs, runIsStopped }) => {
    await choose("Task", "tasks/long.yaml");
    await choose("Robot", "fake");
    await button("Run").tap();
    // The page of before keeps control for some seconds.
    const over = page.getByRole("dialog").getByRole("button", { name: /^Take over control/ });
    await over.or(page.getByRole("treeitem", { name: /^one .*running$/ })).first().waitFor();
    if (await over.isVisible()) await over.tap();
    await runIs("running");
    await nodeIs("one", "running");
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390, "nothing lies beside the screen");
    // Wherever one has scrolled to, STOP is under the thumb, and nothing is over it.
    for (const part of [page.getByRole("tree"), page.getByLabel("Events"), button("STOP")]) {
      await part.first().scrollIntoViewIfNeeded();
      const { x, y, width, height } = await button("STOP").boundingBox();
      assert.ok(y + height <= 844 && y > 700 && width > 300 && height >= 48, JSON.stringify({ x, y, width, height }));
      assert.equal(await page.evaluate(([x, y]) => document.elementFromPoint(x, y)?.textContent, [x + width / 2, y + height / 2]), "STOP");
    }
    await check(page, "on a phone");
    await button("STOP").tap();
    await runIsStopped();
  },
  { hasTouch: true, reducedMotion: "reduce", viewport: { width: 390, height: 844 } },
);
