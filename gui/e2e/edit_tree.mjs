// A task is built and changed in the tree and the outline: by keys, by forms, by dragging; then undone, redone, saved.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { eventually, onPage, rest, url } from "./page.mjs";

const [folder] = rest;
const file = (name) => readFileSync(join(folder, "tasks", name), "utf8");

await onPage(url, async (page, { answer, button, choose, fileIs, item, pick, rowsAre }) => {
  await choose("Task", "tasks/short.yaml");
  const before = file("short.yaml");
  await fileIs("saved");

  // Type to add: after the selected leaf, at the cursor of the outline.
  await pick("first");
  await page.keyboard.press("/");
  await answer("flow/wait");
  await rowsAre(["/", "first", "wait", "attempts", "attempts/broken", "attempts/second", "machine", "machine/a", "machine/b"]);
  await fileIs("not saved");

  // Forms: the problem of a missing parameter is shown and goes with its value; a wrong literal is refused in the field.
  const seconds = page.getByLabel("seconds float");
  await seconds.fill("soon");
  await seconds.press("Enter");
  await page.getByText("A number is needed.").waitFor();
  await seconds.fill("0.25");
  await seconds.press("Enter");
  await page.getByText("No problems.").waitFor();

  // Rename, move, wrap, unwrap from the keyboard.
  await item("wait").focus();
  await page.keyboard.press("F2");
  await answer("pause");
  await item("pause").waitFor();
  await page.keyboard.press("Alt+ArrowUp");
  await rowsAre(["/", "pause", "first", "attempts", "attempts/broken", "attempts/second", "machine", "machine/a", "machine/b"]);
  await item("first").click({ modifiers: ["Control"] });
  await page.keyboard.press("w");
  await answer("fallback");
  await rowsAre(["/", "fallback", "fallback/pause", "fallback/first", "attempts", "attempts/broken", "attempts/second", "machine", "machine/a", "machine/b"]);
  await page.keyboard.press("Shift+W");
  await rowsAre(["/", "pause", "first", "attempts", "attempts/broken", "attempts/second", "machine", "machine/a", "machine/b"]);

  // Change kind, and settings of a container.
  await pick("attempts");
  await page.keyboard.press("k");
  await answer("sequence");
  await item("attempts").getByText("sequence").waitFor({ state: "attached" });
  await page.getByLabel("With memory").selectOption("no");
  await page.getByLabel("With memory").evaluate((field) => field.value === "false");

  // Expression fields are checked while they are typed.
  await page.getByLabel("Precondition").fill("reachd > 1");
  await page.getByText(/isn't declared; did you mean 'reached'/).waitFor();
  await page.getByLabel("Precondition").fill("reached < 5");
  await page.getByLabel("Precondition").press("Enter");
  await page.getByText(/isn't declared/).waitFor({ state: "detached" });

  // Several at once: removed, and back.
  await pick("pause");
  await item("attempts").click({ modifiers: ["Control"] });
  await page.keyboard.press("Delete");
  await rowsAre(["/", "first", "machine", "machine/a", "machine/b"]);
  await page.keyboard.press("Control+z");
  await rowsAre(["/", "pause", "first", "attempts", "attempts/broken", "attempts/second", "machine", "machine/a", "machine/b"]);

  // Dragging: a palette entry into a container, a row elsewhere.
  await page.getByLabel("Search the palette").fill("succeed");
  await page.getByRole("button", { name: "succeed" }).dragTo(page.locator('.react-flow [data-path="attempts"]'));
  await item("succeed").waitFor();
  await item("succeed").dragTo(item("first"), { targetPosition: { x: 60, y: 3 } });
  await rowsAre(["/", "pause", "succeed", "first", "attempts", "attempts/broken", "attempts/second", "machine", "machine/a", "machine/b"]);

  // Across files: a part with the variables that it needs.
  await pick("second");
  await page.keyboard.press("Control+c");
  await page.keyboard.press("Control+s");
  await fileIs("saved");
  const saved = file("short.yaml");
  assert.match(saved, /precondition: reached < 5/);
  await choose("Task", "tasks/long.yaml");
  await rowsAre(["/", "one", "two"]);
  await page.keyboard.press("Control+v");
  await rowsAre(["/", "one", "two", "second"]);
  await page.keyboard.press("Control+s");
  await fileIs("saved");
  assert.match(file("long.yaml"), /second: \{node: test\/count, in: \{value: reached\}/);
  assert.match(file("long.yaml"), /reached: \{type: int, value: 0\}/);

  // Everything is undone to the byte, also what was saved; and redone.
  await choose("Task", "tasks/short.yaml");
  await item("succeed").waitFor();
  // The answer to one press may disable the button before the next: that press then does nothing.
  while (await button("Undo").isEnabled()) {
    await button("Undo").click({ force: true });
  }
  await page.keyboard.press("Control+s");
  await fileIs("saved");
  await eventually(() => file("short.yaml"), before);
  while (await button("Redo").isEnabled()) {
    await button("Redo").click({ force: true });
  }
  await page.keyboard.press("Control+s");
  await fileIs("saved");
  await eventually(() => file("short.yaml"), saved);

  // A branch that was left is reached through the history.
  await page.getByRole("tab", { name: "History" }).click();
  await page.getByRole("button", { name: "rename wait" }).click();
  await rowsAre(["/", "first", "pause", "attempts", "attempts/broken", "attempts/second", "machine", "machine/a", "machine/b"]);

  // Switching views changes nothing.
  for (const view of ["Flow", "Split", "Text", "Tree"]) await button(view).click();
  await button("New task").click();
  await answer("fresh");
  await rowsAre(["/"]);
  await page.getByText(/a sequence without children does nothing/).first().waitFor();
  assert.match(file("fresh.yaml"), /name: fresh/);
});
