// Figures of large tasks for people: node figures.mjs URL TASK opens a task, pans for two seconds, edits, and says how long it took.
import { onPage, rest, url } from "./page.mjs";

const [task = ""] = rest;

await onPage(url, async (page, { button, choose, fileIs, answer }) => {
  const since = async (work) => {
    const start = Date.now();
    await work();
    return Date.now() - start;
  };
  const open = await since(async () => {
    await choose("Task", task);
    await page.waitForFunction((path) => document.querySelectorAll('.react-flow [data-path="/"]').length > 0 && document.querySelectorAll("[role=treeitem]").length > 10 && document.title.startsWith(path), task.replace(/^.*\/|\.yaml$/g, ""));
  });
  // What is measured from here on is the whole task, all containers open.
  await page.keyboard.press("Control+k");
  await answer("Unfold everything");
  await page.getByRole("treeitem").nth(30).waitFor({ state: "attached" });
  const rows = await page.getByRole("treeitem").count();
  const box = await page.locator(".react-flow").boundingBox();
  await page.evaluate(() => {
    window.frames_seen = 0;
    const count = () => {
      window.frames_seen++;
      requestAnimationFrame(count);
    };
    requestAnimationFrame(count);
  });
  await page.mouse.move(box.x + 300, box.y + 30);
  await page.mouse.down();
  const start = Date.now();
  const first = await page.evaluate(() => window.frames_seen);
  for (let i = 0; Date.now() - start < 2000; i++) await page.mouse.move(box.x + 300 + 120 * Math.sin(i / 20), box.y + 30 + (i % 200));
  const frames = (await page.evaluate(() => window.frames_seen)) - first;
  const fps = Math.round((1000 * frames) / (Date.now() - start));
  await page.mouse.up();
  await page.getByRole("treeitem").nth(2).click();
  // Seen in the page itself, from the key to the frame that shows the edit: looking from outside costs more than the edit.
  // The listener is there before the key is pressed, else the time would be that since the page was opened.
  await page.evaluate(() => {
    let began = 0;
    addEventListener("keydown", () => (began = performance.now()), { once: true, capture: true });
    window.edit_seen = new Promise((done) => {
      const look = () => {
        const state = document.querySelector('[aria-label="State of the file"]')?.textContent ?? "";
        if (began && state.includes("not saved")) requestAnimationFrame(() => setTimeout(() => done(Math.round(performance.now() - began))));
        else requestAnimationFrame(look);
      };
      look();
    });
  });
  await page.keyboard.press("Delete");
  const edit = await page.evaluate(() => window.edit_seen);
  await button("Undo").click();
  await fileIs("saved");
  const first_view = await since(async () => {
    await button("Text").click();
    await page.locator(".cm-content").waitFor();
  });
  console.log(JSON.stringify({ task, open_ms: open, outline_rows_mounted: rows, pan_fps: fps, edit_ms: edit, text_ms: first_view }));
});
