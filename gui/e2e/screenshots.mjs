// Pictures of the page for people: node screenshots.mjs URL FOLDER [TASK [SEED [SECONDS]]] runs a task and looks three times.
import { mkdirSync } from "node:fs";
import { join } from "node:path";

import { onPage, rest, url } from "./page.mjs";

const [folder = ".", task = "", seed = "0", seconds = "6"] = rest;
mkdirSync(folder, { recursive: true });

for (const colorScheme of ["light", "dark"]) {
  for (const [width, height] of [[1280, 720], [1920, 1080]]) {
    await onPage(
      url,
      async (page, { button, choose }) => {
        const shoot = (name) => page.screenshot({ path: join(folder, `${name}-${colorScheme}-${width}.png`) });
        if (task) await choose("Task", task);
        await choose("Robot", process.env.ROBOT ?? "sim");
        if (seed !== "0") {
          await page.locator(".bar summary").click();
          await page.getByLabel("Seed").fill(seed);
          await page.keyboard.press("Escape");
        }
        await shoot("before");
        await button("Run").click();
        await page.waitForTimeout(Number(seconds) * 1000);
        await shoot("running");
        await button("STOP").click();
        await button("Run").isEnabled();
        await page.waitForTimeout(1500);
        await page.getByRole("slider").focus();
        for (let i = 0; i < 3; i++) await page.keyboard.press("PageDown");
        await shoot("after");
      },
      { colorScheme, viewport: { width, height }, reducedMotion: "reduce" },
    );
  }
}
