// The robot in 3D at the moments of a recorded run: the page's forward kinematics are those of the robot's model.
import assert from "node:assert/strict";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { onPage, rest, url } from "./page.mjs";

const [run, expected, shots] = rest;
const [first, last] = JSON.parse(expected);

function near(text, wanted) {
  const found = /\((.*?)\)/.exec(text)[1].split(", ").map(Number);
  assert.ok(found.every((value, at) => Math.abs(value - wanted[at]) < 2e-3), `${text} isn't at ${wanted}`);
}

for (const colorScheme of ["light", "dark"]) {
  await onPage(
    url,
    async (page, { button, choose, slider }) => {
      const words = page.getByRole("group", { name: "The drawing in words" });
      await page.getByRole("tab", { name: "Run" }).click();
      await choose("Run to look at", run);
      await button("Robot in 3D").focus();
      await page.keyboard.press("Enter");
      await page.getByLabel("What is drawn").getByText("23 joints as measured at 2.50 s").waitFor();
      const canvas = page.getByRole("application", { name: /^panda_allegro: 23 joints/ });
      await canvas.waitFor();
      await page.getByText("2 objects, 3 poses, in words").click();
      const grasp = words.getByText("grasp frame of palm");

      // At the end, then scrubbed to the beginning: joints, objects, what is held, and poses.
      await words.getByText("cup: cylinder (0.040, 0.120) m held by palm").waitFor();
      near(await grasp.textContent(), last);
      await words.getByText("chosen before: (0.500, 0.100, 0.300) m in world").waitFor();
      if (shots) await page.screenshot({ path: join(shots, `robot-${colorScheme}.png`) });
      await slider().focus();
      await page.keyboard.press("Home");
      await words.getByText("cup: cylinder (0.040, 0.120) m at (0.500, 0.100, 0.060) m").waitFor();
      near(await grasp.textContent(), first);
      await page.getByText("2 objects, 0 poses, in words").waitFor();

      // By keys, by buttons; frames are shown.
      const picture = () => page.locator(".robot-canvas canvas").screenshot();
      const changes = async (work) => {
        const before = await picture();
        await work();
        for (let at = 0; at < 200; at++) {
          if (!before.equals(await picture())) return;
          await page.waitForTimeout(50);
        }
        assert.fail("the picture stays the same");
      };
      await canvas.focus();
      await changes(() => page.keyboard.press("ArrowLeft"));
      await changes(() => page.keyboard.press("+"));
      await changes(() => page.getByRole("checkbox", { name: "Frames" }).check());
      await changes(() => button("Above").click());
      await check(page, `${colorScheme}, robot in 3D`);
      await button("Close").click();
      await canvas.waitFor({ state: "detached" });
    },
    { colorScheme, reducedMotion: "reduce", deviceScaleFactor: 1 },
  );
}
