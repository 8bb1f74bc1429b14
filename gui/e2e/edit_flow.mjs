// A state machine is drawn: nodes, edges by dragging and by keys, the start, pins; what is ambiguous is asked.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { onPage, rest, url } from "./page.mjs";

const [folder] = rest;

await onPage(url, async (page, { answer, button, choose, dragUntil, fileIs, item, more, pick }) => {
  const box = (path) => page.locator(`.flow [data-path="${path}"]`);
  const port = (path, outcome) => box(path).locator(".port", { hasText: outcome }).locator(".react-flow__handle");
  const end = (outcome) => page.locator(".flow .end-node", { hasText: outcome });
  const edge = (name) => page.locator(`.flow .react-flow__edge[data-id="${name}"]`);

  await choose("Task", "tasks/short.yaml");
  await fileIs("saved");
  await pick("machine");
  await page.keyboard.press("Enter");
  await box("machine/a").waitFor();
  await edge("machine/a.success").waitFor({ state: "attached" });
  await page.getByRole("navigation", { name: "Containers" }).getByRole("button", { name: "short" }).waitFor();
  await page.getByText("= both forms").first().waitFor();

  // The container in a pane of its own.
  const [pane] = await Promise.all([page.waitForEvent("popup"), page.getByRole("link", { name: "Open this container in a pane of its own" }).click()]);
  await pane.locator('.flow [data-path="machine/b"]').waitFor();
  await pane.close();

  // Add into the chart, connect its free outcome by keys, then all that is free at once.
  await page.keyboard.press("/");
  await answer("flow/fail");
  await box("machine/fail").waitFor();
  await page.keyboard.press("c");
  await answer("failure");
  await page.getByRole("dialog", { name: /leads to/ }).waitFor();
  await answer("b");
  await edge("machine/fail.failure").waitFor({ state: "attached" });

  // By dragging from a port: to a node and to an end; a second target takes the first one's place.
  await port("machine/a", "success").dragTo(box("machine/fail").locator(".react-flow__handle-left"));
  await page.waitForFunction(() => document.querySelector('.flow .react-flow__edge[data-id="machine/a.success"]')?.getAttribute("aria-label")?.includes("machine/fail") ?? false);
  await page.keyboard.press("Control+z");
  await page.waitForFunction(() => document.querySelector('.flow .react-flow__edge[data-id="machine/a.success"]')?.getAttribute("aria-label")?.includes("machine/b") ?? false);

  // The start, by dragging its mark. The undo has brought a problem back: when it is listed, the chart has less room, and moves.
  await page.getByLabel("Problems of the task").waitFor();
  await page.locator(".flow .start-node .react-flow__handle").dragTo(box("machine/b").locator(".react-flow__handle-left"));
  await pick("machine");
  await page.waitForFunction(() => [...document.querySelectorAll("select")].some((field) => field.value === "b" && field.labels?.[0]?.textContent?.includes("Begins with")));

  // An edge is taken out: click it, then remove.
  await edge("machine/b.success").locator("path").first().click({ force: true });
  await page.getByRole("button", { name: "Remove this edge" }).click();
  await edge("machine/b.success").waitFor({ state: "detached" });
  await button("Connect free outcomes").click();
  await edge("machine/b.success").waitFor({ state: "attached" });

  // A pinned node never moves by itself: not when others come, not when they go.
  await dragUntil(box("machine/a").locator(".node-sub"), 60, 120, page.getByRole("button", { name: "Tidy up (1 pinned)" }));
  const place = () => page.locator('.flow .react-flow__node[data-id="machine/a"]').evaluate((node) => node.style.transform);
  const pinned = await place();
  await pick("b");
  await page.keyboard.press("/");
  await answer("flow/log");
  await box("machine/log").waitFor();
  assert.equal(await place(), pinned);
  await page.keyboard.press("Delete");
  await box("machine/log").waitFor({ state: "detached" });
  assert.equal(await place(), pinned);
  await page.keyboard.press("Control+s");
  await fileIs("saved");
  assert.match(readFileSync(join(folder, "tasks/short.layout.yaml"), "utf8"), /^flow:\n {2}machine\/a: \[-?\d+, -?\d+\]\n$/);

  // In a sequence there are no edges between siblings: the person says what is meant, and one undo takes it back.
  await page.keyboard.press("Backspace");
  await box("first").waitFor();
  await page.getByText(/Dotted edges follow from the sequence/).waitFor();
  await port("first", "success").dragTo(box("machine").locator(".react-flow__handle-left"));
  const dialog = page.getByRole("dialog", { name: "first.success to machine?" });
  await dialog.getByText(/its order decides/).waitFor();
  await dialog.getByRole("button", { name: /Make short a state machine/ }).click();
  await edge("first.success").waitFor({ state: "attached" });
  await item("short").getByText("state machine").waitFor({ state: "attached" });
  await page.keyboard.press("Control+z");
  await item("short").getByText("sequence").waitFor({ state: "attached" });

  // Another task of the project as a step; its outcomes are ports.
  await pick("first");
  await page.keyboard.press("/");
  await answer("tasks/long.yaml");
  await item("long").getByText("subtask").waitFor({ state: "attached" });
  await page.keyboard.press("Delete");
  await item("long").waitFor({ state: "detached" });

  // An outcome is renamed with all that leads to it.
  await pick("machine");
  await page.getByRole("button", { name: "Rename the outcome done" }).click();
  await answer("finished");
  await page.getByRole("button", { name: "Rename the outcome finished" }).waitFor();

  // Convert: looked at first, and one edit.
  await pick("attempts");
  await more("Convert");
  await answer("machine");
  const conversion = page.getByRole("dialog", { name: "attempts as a state machine" });
  await conversion.getByText("Both forms do the same.").waitFor();
  await conversion.getByRole("button", { name: /^Convert/ }).click();
  await item("attempts").getByText("state machine").waitFor({ state: "attached" });

  // Search over everything, also values.
  await page.keyboard.press("Control+f");
  await answer("the way is blocked");
  await page.locator('[role="treeitem"][aria-selected="true"][data-row="attempts/broken"]').waitFor();

  // The lens: who writes and reads a variable.
  await button("Tree").click();
  await page.locator("table").getByRole("button", { name: "reached" }).click();
  await page.locator('.react-flow [data-path="attempts/second"]').getByText("writes, reads").waitFor();
});
