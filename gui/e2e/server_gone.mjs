// The server is killed and started again: says READY, waits for lines KILLED and BACK; the page tells, keeps what was typed, and comes back by itself.
import assert from "node:assert/strict";
import { createInterface } from "node:readline";

import { check } from "./axe.mjs";
import { eventually, onPage, url } from "./page.mjs";

const lines = createInterface({ input: process.stdin })[Symbol.asyncIterator]();
const heard = async (word) => assert.equal((await lines.next()).value, word);

await onPage(
  url,
  async (page, { button, choose, fileIs, item, pick }) => {
    await choose("Task", "tasks/short.yaml");
    await fileIs("saved");
    await pick("first");
    const seconds = page.getByLabel(/^seconds/).first();
    await seconds.fill("4");
    await page.keyboard.press("Enter");
    await fileIs("not saved");
    console.log("READY");
    await heard("KILLED");

    const gone = page.getByRole("alert").filter({ hasText: "The server doesn't answer." });
    await gone.waitFor();
    await page.getByRole("button", { name: /STOP is dead/ }).waitFor();
    assert.equal(await page.getByRole("button", { name: /STOP/ }).isDisabled(), true);
    await check(page, "no server");

    // What is edited and typed now waits.
    await seconds.fill("5");
    await page.keyboard.press("Enter");
    await gone.getByText("1 edit waits for it").waitFor();
    await page.getByLabel("State of the file").getByText("waits for the server").waitFor();
    assert.equal(await seconds.inputValue(), "5");
    console.log("WAITS");
    await heard("BACK");

    await gone.waitFor({ state: "detached" });
    await fileIs("not saved");
    await button("STOP").waitFor();
    assert.equal(await seconds.inputValue(), "5");
    await eventually(() => page.getByRole("alert").count(), 0);

    // Text that was typed meanwhile, too, also when another view is looked at.
    await button("Text").click();
    await page.locator(".cm-content").waitFor();
    await page.getByText("seconds: 5").waitFor();
    console.log("READY");
    await heard("KILLED");
    await gone.waitFor();
    await page.locator(".cm-content").click();
    await page.keyboard.press("Control+End");
    await page.keyboard.type("\n# typed while nobody listened");
    await button("Tree").click();
    await item("first").waitFor();
    console.log("WAITS");
    await heard("BACK");
    await gone.waitFor({ state: "detached" });
    await button("Text").click();
    await page.getByText("# typed while nobody listened").waitFor();
    await page.keyboard.press("Control+s");
    await fileIs("saved");
  },
  { expected: /status of 409|ERR_CONNECTION_REFUSED|WebSocket|Failed to load resource/, reducedMotion: "reduce" },
);
process.stdin.destroy(); // else it waits for further lines
