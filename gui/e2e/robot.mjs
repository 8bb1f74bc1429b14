// The robot in 3D at the moments of a recorded run: the page's forward kinematics are those of the robot's model.
import assert from "node:assert/strict";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [run, expected, shots] = rest;
const [first, last] = JSON.parse(expected);

/** Wait until what `line` says is where it is wanted. */
async function near(line, wanted) {
  const place = async () => /\((.*?)\)/.exec(await line.textContent())[1].split(", ").map(Number);
  await eventually(place, (found) => found.every((value, at) => Math.abs(value - wanted[at]) < 2e-3), `it isn't at ${wanted}`);
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
      await page.getByText("4 objects, 3 poses, 1 cloud, in words").click();
      const grasp = words.getByText("grasp frame of palm");

      // At the end, then scrubbed to the beginning: joints, objects, what is held, and poses.
      await words.getByText("cup: cylinder (0.040, 0.120) m held by palm").waitFor();
      await near(grasp, last);
      // What presses, and the way that was gone; scrubbed to before, it is planned.
      const legend = page.getByRole("list", { name: "Legend" });
      await words.getByText("hand_link_3.0_tip presses on cup with 5.0 N at (0.500, 0.100, 0.310) m, towards (0.000, 1.000, 0.000)").waitFor();
      await words.getByText("right has gone a way of 2 points").waitFor();
      await legend.getByText("5 cm = 2 N").waitFor();
      await legend.getByText("gone").waitFor();
      await words.getByText("chosen before: (0.500, 0.100, 0.300) m in world").waitFor();
      await words.getByText("wedge: mesh within (0.200, 0.200, 0.300) m at (0.600, -0.400, 0.000) m").waitFor();
      await words.getByText("seen: cells of (0.030) m at (0.400, 0.400, 0.000) m").waitFor();
      await words.getByText("cloud: cloud of 600 points in world").waitFor();
      if (shots) await page.screenshot({ path: join(shots, `robot-${colorScheme}.png`) });
      await slider().focus();
      await page.keyboard.press("Home");
      await words.getByText("cup: cylinder (0.040, 0.120) m at (0.500, 0.100, 0.060) m").waitFor();
      await near(grasp, first);
      await page.getByText("2 objects, 0 poses, in words").waitFor();
      await legend.waitFor({ state: "detached" });
      for (const seen of ["planned", "goes"]) {
        await eventually(async () => {
          await page.keyboard.press("ArrowRight");
          return legend.getByText(seen).count();
        }, 1);
      }

      const picture = () => page.locator(".robot-canvas canvas").screenshot();
      const changes = async (work) => {
        const before = await picture();
        await work();
        await eventually(async () => before.equals(await picture()), false, "the picture stays the same");
      };
      // Meshes, cells and clouds are drawn: without them the picture is another one.
      await page.keyboard.press("End");
      await words.getByText("wedge: mesh").waitFor();
      // Nothing of the bar is cut off.
      const pane = await page.getByRole("region", { name: "Robot in 3D" }).boundingBox();
      for (const control of [button("Close"), page.getByRole("checkbox", { name: "Clouds" })]) {
        const { x, width } = await control.boundingBox();
        assert.ok(x >= pane.x && x + width <= pane.x + pane.width, "the camera's bar fits into the pane");
      }
      await changes(() => page.getByRole("checkbox", { name: "Clouds" }).uncheck());
      await page.getByRole("checkbox", { name: "Clouds" }).check();

      // By keys, by buttons; frames are shown.
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
