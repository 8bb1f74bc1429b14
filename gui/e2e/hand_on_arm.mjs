// An arm without a hand: which hand is asked, both are put together, and the first task holds something with them, by seven presses and a name.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { onPage, rest, url } from "./page.mjs";

const [folder] = rest;

await onPage(
  url,
  async (page, { answer, button, nodeIs, runIs }) => {
    const has = page.getByRole("list", { name: "What the project has" }).getByRole("listitem");
    await page.getByRole("button", { name: /^Take a robot/ }).click();
    await page.getByRole("list", { name: "Ready-made robots" }).getByRole("button", { name: /^ur5 / }).click();
    await button("Take ur5").click();
    await page.getByRole("heading", { name: "The project is there" }).waitFor();
    await has.filter({ hasText: /Hands.*none yet/ }).waitFor();
    await button("Add hands").click();
    await page.getByRole("dialog").getByRole("heading", { name: "Which hand?" }).waitFor();
    await check(page, "question: which hand");
    await answer("shadow_right");
    await has.filter({ hasText: /Hands.*hand/ }).filter({ hasNotText: "none yet" }).waitFor();
    await has.filter({ hasText: "ur5 with shadow_right" }).waitFor();
    await has.filter({ hasText: /World.*bench/ }).waitFor();
    assert.match(readFileSync(join(folder, "grip.yaml"), "utf8"), /states:\n {4}arm:\n {6}home:/, "its own home is in the bench");
    await button("Open the first task").click();
    await nodeIs("held", "not started");
    await page.getByText("No problems.").waitFor();
    await button("Run").click();
    await runIs("success: success");
    await page.locator(".robot-words summary").click();
    await page.getByLabel("The drawing in words").getByText(/held by hand/).waitFor();
  },
  { reducedMotion: "reduce" },
);
