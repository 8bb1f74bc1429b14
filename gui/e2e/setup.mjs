// The files that put a project together: form and text are one, faults are placed, a component is made, tried, and drawn with.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder] = rest;
const file = (path) => readFileSync(join(folder, path), "utf8");

for (const colorScheme of ["light", "dark"]) {
  await onPage(
    url,
    async (page, { button, fileIs }) => {
      const form = page.getByRole("group", { name: "Form" });
      const field = (name) => form.getByLabel(name, { exact: true });
      const text = page.getByLabel("Text of the file");
      const fault = page.getByRole("list", { name: "Problems of the file" });
      const put = async (name, value) => {
        await field(name).fill(value);
        await page.keyboard.press("Enter");
      };
      await button("Project").click();
      await field("robot").waitFor();
      await button("Text").click();

      if (colorScheme === "dark") {
        await put("planner", "RRTConect");
        await fault.getByText("did you mean 'RRTConnect'").waitFor();
        await check(page, "dark");
        return;
      }

      // From a template, by a field, and by text.
      await page.getByLabel("Insert a template").selectOption("Panda with an Allegro hand");
      await page.getByLabel("Insert a template").selectOption("an arm with a hand");
      await fault.getByText("there is no 'right_hand'").waitFor();
      await check(page, "faults");
      await page.getByLabel("Insert a template").selectOption("a hand");
      await form.getByText("Nothing is wrong").waitFor();
      await put("planner", "RRTConect");
      await fault.getByText("did you mean 'RRTConnect'").waitFor();
      await eventually(() => field("planner").getAttribute("aria-invalid"), "true");
      await fault.getByRole("button").click();
      await eventually(() => page.evaluate(() => document.activeElement?.getAttribute("aria-label") ?? ""), (label) => /Text of the file/.test(label));
      await put("planner", "BiTRRT");
      await form.getByText("Nothing is wrong").waitFor();
      await text.click();
      await page.keyboard.press("Control+End");
      await page.keyboard.type("\nworld: table");
      await page.waitForFunction(() => [...document.querySelectorAll("input")].some((input) => input.value === "table"));
      await check(page, "form");
      await page.keyboard.press("Control+s");
      await fileIs("saved");
      await eventually(() => file("grip.yaml"), (saved) => /planner: BiTRRT/.test(saved));

      // A pasted interface: the field that is wrong is named, then the node is generated and tried.
      await page.getByText("New component").click();
      await button("Template").click();
      await page.getByText("It keeps the contract").waitFor();
      const pasted = page.getByLabel("Its .srv or .action");
      await pasted.fill((await pasted.inputValue()).replace("int32 outcome", "string outcome"));
      await page.getByRole("list", { name: "Problems" }).getByText("'outcome' is string; it must be one integer").waitFor();
      await check(page, "interface");
      await button("Template").click();
      await page.getByLabel("Outcomes", { exact: true }).fill("found,none");
      await page.getByLabel("Failures", { exact: true }).fill("none");
      await page.getByLabel("Component", { exact: true }).fill("seer");
      await button("Generate").click();
      await page.getByRole("main", { name: "Component", exact: true }).waitFor();
      assert.match(file("components/seer/node/manifest.yaml"), /none: failure/);
      await button("Generate the node").click();
      await page.getByLabel("Output of the command").getByText("up to date").waitFor();
      await check(page, "component");

      // A named pose.
      await page.getByText("Named poses").click();
      await page.getByLabel("Insert a template").selectOption("a pose");
      await put("z", "0.55");
      await button("Save").click();
      await fileIs("saved");
      assert.match(file("messages/poses.yaml"), /z: 0.55/);

      await button("Tasks").click();
      await page.getByPlaceholder("Type to find a node").fill("seer");
      await page.getByRole("button", { name: /seer/ }).waitFor();
    },
    { colorScheme, reducedMotion: "reduce" },
  );
}
