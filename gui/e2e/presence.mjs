// Two people on one task: each sees where the other is, by colour and initials, in every view, until the other leaves.
import assert from "node:assert/strict";

import { check } from "./axe.mjs";
import { eventually, onPage, PATIENCE, url, words } from "./page.mjs";

await onPage(url, async (ann, one) => {
  // Another browser: what a person is called is kept by each.
  const other = await ann.context().browser().newContext({ viewport: { width: 1280, height: 720 }, reducedMotion: "reduce" });
  const bob = await other.newPage();
  bob.setDefaultTimeout(PATIENCE);
  const two = words(bob);
  await bob.goto(url);
  await bob.getByRole("tree").waitFor();
  for (const [page, name] of [[ann, "Ann Lee"], [bob, "Bob"]]) {
    await page.getByRole("button", { name: /Change your name/ }).click();
    await words(page).answer(name);
  }
  await Promise.all([one.choose("Task", "tasks/short.yaml"), two.choose("Task", "tasks/short.yaml")]);
  await two.item("broken").waitFor();
  await one.item("broken").waitFor();

  /** Where on `page` somebody else's ring is, as `path: initials`, once `wanted` is what there is. */
  const rings = async (page, wanted) => {
    const now = () =>
      page.locator(".node:has(> .others-ring)").evaluateAll((nodes) =>
        nodes.map((node) => `${node.dataset.path}: ${[...node.querySelectorAll(".other-dot")].map((dot) => dot.textContent).join(" ")}`).sort(),
      );
    await eventually(now, wanted);
  };

  // Tree and outline, several at once.
  await two.pick("broken");
  await rings(ann, ["attempts/broken: Bo"]);
  await two.item("second").click({ modifiers: ["Control"] });
  await rings(ann, ["attempts/broken: Bo", "attempts/second: Bo"]);
  const row = ann.locator('[role="treeitem"][data-row="attempts/broken"]');
  await eventually(() => row.getAttribute("aria-description"), "selected by Bob");
  await eventually(() => row.locator(".other-dot").textContent(), "Bo");
  await ann.locator('.node[data-path="attempts/broken"]').getByText("selected by Bob").waitFor({ state: "attached" });
  await one.pick("machine");
  await rings(bob, ["machine: AL"]);
  await check(ann, "with somebody else's selection");

  // Where the node is folded away, its container shows it.
  await ann.getByRole("button", { name: "Inside of attempts" }).click();
  await rings(ann, ["attempts: Bo"]);
  await ann.getByRole("button", { name: "Inside of attempts" }).click();
  await rings(ann, ["attempts/broken: Bo", "attempts/second: Bo"]);

  // Flow: what is inside a container that isn't opened is at the container.
  await one.button("Flow").click();
  await rings(ann, ["attempts: Bo"]);
  await ann.getByRole("button", { name: "Inside of attempts in place" }).click();
  await rings(ann, ["attempts/broken: Bo", "attempts/second: Bo"]);
  await one.button("Tree").click();

  // Without motion for who wants none.
  const moves = (page) => page.locator(".others-ring").first().evaluate((ring) => getComputedStyle(ring).animationName);
  assert.equal(await moves(ann), "appear");
  assert.equal(await moves(bob), "none");

  // In another task nobody is here; back again, and gone with the page.
  await two.choose("Task", "tasks/long.yaml");
  await rings(ann, []);
  await two.choose("Task", "tasks/short.yaml");
  await two.item("first").waitFor();
  await two.pick("first");
  await rings(ann, ["first: Bo"]);
  if (process.env.LOOK) await ann.screenshot({ path: process.env.LOOK });
  // A rename moves the ring with the node, on both pages.
  await bob.keyboard.press("F2");
  await two.answer("begin");
  await rings(ann, ["begin: Bo"]);
  await other.close();
  await rings(ann, []);
  assert.equal(await ann.locator(".other-dot").count(), 0);
});
