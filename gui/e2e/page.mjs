// Opens the editor in the system's Chromium and gives tests a few words of their own.
import assert from "node:assert/strict";
import { setTimeout as sleep } from "node:timers/promises";
import { isDeepStrictEqual } from "node:util";

import { chromium } from "playwright-core";

const EXECUTABLE = process.env.CHROMIUM ?? "/usr/bin/chromium";
/** How long the page may take for anything [ms]: enough for a machine that does much else. */
export const PATIENCE = Number(process.env.PATIENCE ?? 120_000);

/** Wait until `read()` gives what is wanted (a value, or a test of one), and return that; a busy machine shows everything later. */
export async function eventually(read, wanted, told = "it never comes to that") {
  const is = typeof wanted === "function" ? wanted : (value) => isDeepStrictEqual(value, wanted);
  const deadline = Date.now() + PATIENCE;
  for (;;) {
    const value = await read();
    if (is(value)) return value;
    if (Date.now() > deadline) {
      if (typeof wanted !== "function") assert.deepEqual(value, wanted, told);
      assert.fail(`${told}: ${JSON.stringify(value)}`);
    }
    await sleep(40);
  }
}

/** Run `test(page, words)` on the page at `url`; whatever the page complains about fails the test, but for what `expected` matches. */
export async function onPage(url, test, { expected = /status of 409/, ...options } = {}) {
  const browser = await chromium.launch({
    executablePath: EXECUTABLE,
    args: ["--no-sandbox", "--disable-dev-shm-usage"],
    timeout: PATIENCE,
  });
  const complaints = [];
  try {
    const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, ...options });
    context.setDefaultTimeout(PATIENCE); // also of pages that are opened from this one
    const page = await context.newPage();
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.on("console", (message) => {
      // A conflict (409) is a refusal that the page shows and the person decides.
      if (message.type() !== "error" || expected.test(message.text())) return;
      complaints.push(`${message.text()} (${message.location().url.split("?token")[0]})`);
    });
    await page.goto(url);
    await page.getByRole("tree").or(page.getByRole("main", { name: "Begin" })).waitFor();
    await test(page, words(page)).catch(async (error) => {
      if (complaints.length > 0) console.error(`the page complained: ${complaints.join("\n")}`);
      if (process.env.SHOT) await page.screenshot({ path: process.env.SHOT });
      throw error;
    });
    if (complaints.length > 0) throw new Error(`the page complains: ${complaints.join("\n")}`);
  } finally {
    await browser.close();
  }
}

/** What tests say about the page, by role and text. */
export function words(page) {
  return {
    button: (name) => page.getByRole("button", { name, exact: true }),
    /** Wait until the run's state says `text`. */
    runIs: (text) => page.getByLabel("State of the run").getByText(text, { exact: true }).waitFor(),
    /** Wait until STOP has ended the run: where a machine is so busy that it doesn't answer in time, it is killed. */
    runIsStopped: () => page.getByLabel("State of the run").getByText(/^(stopped|killed)$/).waitFor(),
    /** Wait until the outline says that `node` is `status`. */
    nodeIs: (node, status) =>
      page.getByRole("treeitem", { name: new RegExp(`^${node} [a-z ]+, ${status}$`) }).waitFor({ state: "attached" }),
    /** Do one of the further things that can be done with the selected node. */
    more: async (name) => {
      await page.locator(".actions summary").click();
      await page.locator(".actions").getByRole("button", { name, exact: true }).click();
    },
    choose: (label, value) => page.getByLabel(label, { exact: true }).selectOption(value),
    item: (name) => page.getByRole("treeitem", { name: new RegExp(`^${name} `) }),
    /** Select a node in the outline, with the focus on it. */
    pick: async (name) => {
      await page.getByRole("treeitem", { name: new RegExp(`^${name} `) }).click();
    },
    /** The names in the outline, in order. */
    names: () => page.getByRole("treeitem").evaluateAll((rows) => rows.map((row) => row.getAttribute("data-row"))),
    /** Wait until the outline has these rows. */
    rowsAre: (rows) =>
      eventually(() => page.getByRole("treeitem").evaluateAll((all) => all.map((row) => row.getAttribute("data-row"))), rows),
    /** Wait until the file's state says `text`. */
    fileIs: (text) => page.getByLabel("State of the file").getByText(text, { exact: true }).waitFor(),
    /** Answer the open dialog: type, then Enter; where there are only a few choices, press the one that says it. */
    answer: async (text) => {
      const dialog = page.getByRole("dialog");
      const title = await dialog.getByRole("heading").textContent();
      const few = dialog.locator(".few-choices [role=group] button");
      await few.or(dialog.locator("input")).first().waitFor();
      if ((await few.count()) > 0) {
        const named = few.filter({ has: page.getByText(text, { exact: true }) });
        await ((await named.count()) > 0 ? named : few.filter({ hasText: text })).first().click();
      } else {
        await dialog.locator("input").fill(text);
        await page.keyboard.press("Enter");
      }
      await page.getByRole("dialog").getByRole("heading", { name: title, exact: true }).waitFor({ state: "detached" });
    },
    /** Where something is, once it stands still: a chart moves when it is fitted, and a drag that begins beside a node moves nothing. */
    still: async (what) => {
      await what.hover(); // waits until it stands still, can be reached and isn't covered
      return what.boundingBox();
    },
    /** Drag something to so far from its upper left corner, until `done` is seen: a chart that moves just then leaves the pointer beside it. */
    dragUntil: async (what, right, down, done) => {
      for (let tries = 0; tries < 10; tries++) {
        await what.hover();
        const { x, y, width, height } = await what.boundingBox();
        await page.mouse.move(x + width / 2, y + height / 2);
        await page.mouse.down();
        await page.mouse.move(x + right, y + down, { steps: 6 });
        await page.mouse.up();
        if (await done.waitFor({ timeout: 5000 }).then(() => true, () => false)) return;
      }
      await done.waitFor();
    },
    slider: () => page.getByRole("slider", { name: "Moment of the run" }),
  };
}

/** The address of the page and other arguments of a test script. */
export const [url, ...rest] = process.argv.slice(2);
