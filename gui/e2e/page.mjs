// Opens the editor in the system's Chromium and gives tests a few words of their own.
import { chromium } from "playwright-core";

const EXECUTABLE = process.env.CHROMIUM ?? "/usr/bin/chromium";
const PATIENCE = 30_000;

/** Run `test(page, words)` on the page at `url`; whatever the page complains about fails the test. */
export async function onPage(url, test, options = {}) {
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
      if (message.type() === "error") complaints.push(message.text());
    });
    await page.goto(url);
    await page.getByRole("tree").waitFor();
    await test(page, words(page));
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
    slider: () => page.getByRole("slider", { name: "Moment of the run" }),
  };
}

/** The address of the page and other arguments of a test script. */
export const [url, ...rest] = process.argv.slice(2);
