// Opens the editor in the system's Chromium and gives tests a few words of their own.
import assert from "node:assert/strict";

import { chromium } from "playwright-core";

const EXECUTABLE = process.env.CHROMIUM ?? "/usr/bin/chromium";
/** How long the page may take for anything [ms]: enough for a machine that does much else. */
export const PATIENCE = 120_000;

/** Run `test(page, words)` on the page at `url`; whatever the page complains about fails the test, but for what `expected` matches. */
export async function onPage(url, test, { expected = /status of 409/, ...options } = {}) {
  const browser = await chromium.launch({
    executablePath: EXECUTABLE,
    args: ["--no-sandbox", "--disable-dev-shm-usage"],
  });
  const complaints = [];
  try {
    const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, ...options });
    const page = await context.newPage();
    page.setDefaultTimeout(PATIENCE);
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.on("console", (message) => {
      // A conflict (409) is a refusal that the page shows and the person decides.
      if (message.type() === "error" && !expected.test(message.text())) complaints.push(message.text());
    });
    await page.goto(url);
    await page.getByRole("tree").waitFor();
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
    /** Wait until the outline says that `node` is `status`. */
    nodeIs: (node, status) =>
      page.getByRole("treeitem", { name: new RegExp(`^${node} [a-z ]+, ${status}$`) }).waitFor({ state: "attached" }),
    choose: (label, value) => page.getByLabel(label, { exact: true }).selectOption(value),
    item: (name) => page.getByRole("treeitem", { name: new RegExp(`^${name} `) }),
    /** Select a node in the outline, with the focus on it. */
    pick: async (name) => {
      await page.getByRole("treeitem", { name: new RegExp(`^${name} `) }).click();
    },
    /** The names in the outline, in order. */
    names: () => page.getByRole("treeitem").evaluateAll((rows) => rows.map((row) => row.getAttribute("data-row"))),
    /** Wait until the outline has these rows. */
    rowsAre: async (rows) => {
      const now = () => page.getByRole("treeitem").evaluateAll((all) => all.map((row) => row.getAttribute("data-row")));
      const deadline = Date.now() + PATIENCE;
      while (Date.now() < deadline && JSON.stringify(await now()) !== JSON.stringify(rows)) await page.waitForTimeout(40);
      assert.deepEqual(await now(), rows);
    },
    /** Wait until the file's state says `text`. */
    fileIs: (text) => page.getByLabel("State of the file").getByText(text, { exact: true }).waitFor(),
    /** Answer the open dialog: type, then Enter. */
    answer: async (text) => {
      const title = await page.getByRole("dialog").getByRole("heading").textContent();
      await page.getByRole("dialog").locator("input").fill(text);
      await page.keyboard.press("Enter");
      await page.getByRole("dialog").getByRole("heading", { name: title, exact: true }).waitFor({ state: "detached" });
    },
    slider: () => page.getByRole("slider", { name: "Moment of the run" }),
  };
}

/** The address of the page and other arguments of a test script. */
export const [url, ...rest] = process.argv.slice(2);
