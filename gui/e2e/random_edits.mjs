// Two browsers edit one task at random, by the page's own keys, both at once: node random_edits.mjs URL TASK EDITS SEED
// At each stop both show what the server has: node for node, line for line. At the end the file is saved.
import assert from "node:assert/strict";

import { eventually, onPage, PATIENCE, rest, url, words } from "./page.mjs";

const [task, edits, seed] = [rest[0], Number(rest[1]), Number(rest[2])];
const BETWEEN = 30;
/** So many edits are kept in a history, with room for the last round. */
const REACH = 900;

/** Runs in the page: counts the wishes about documents that were sent, and those without an answer. */
function count() {
  window.wishes = { sent: 0, open: 0, refused: 0 };
  const fetched = window.fetch;
  window.fetch = async (input, init) => {
    if (init?.method !== "POST" || !String(input).includes("/api/document/")) return fetched(input, init);
    window.wishes.sent++;
    window.wishes.open++;
    try {
      const answer = await fetched(input, init);
      if (!answer.ok) window.wishes.refused++;
      return answer;
    } finally {
      window.wishes.open--;
    }
  };
}

/** Runs in the page: `count` gestures of a person who doesn't wait for answers. */
async function gestures({ seed, count }) {
  let state = seed;
  const random = () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
  const pick = (list) => list[Math.floor(random() * list.length)];
  const wait = (time) => new Promise((done) => setTimeout(done, time));
  const press = (target, key, held = {}) => target.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...held }));
  const dialog = () => document.querySelector("dialog[open] input, dialog[open] .few-choices");
  const type = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  const NODES = ["flow/wait", "flow/fail", "flow/succeed", "sequence", "fallback", "parallel", "state machine"];
  const KINDS = ["sequence", "fallback", "parallel", "retry", "timeout", "invert", "state machine"];
  const NAMES = ["look", "take", "put", "again", "a", "b", "x1"];
  const alt = { altKey: true };
  const ctrl = { ctrlKey: true };
  const GESTURES = [
    ["/", {}, NODES], ["/", {}, NODES], ["/", {}, NODES], ["w", {}, KINDS], ["k", {}, KINDS], ["F2", {}, NAMES], ["F2", {}, NAMES],
    ["W", { shiftKey: true }], ["Delete", {}], ["ArrowUp", alt], ["ArrowDown", alt], ["ArrowLeft", alt], ["ArrowRight", alt],
    ["d", ctrl], ["c", ctrl], ["v", ctrl], ["z", ctrl], ["z", ctrl], ["y", ctrl], ["C", { shiftKey: true }],
  ];
  for (let at = 0; at < count; at++) {
    const rows = [...document.querySelectorAll('[role="treeitem"]')];
    const row = pick(rows);
    row.click();
    const [key, held, answers] = rows.length > 40 && random() < 0.5 ? ["Delete", {}] : pick(GESTURES);
    press(row, key, held);
    for (let tries = 0; answers && dialog() === null && tries < 20; tries++) await wait(5);
    const field = dialog();
    if (field?.matches(".few-choices") && answers) pick([...field.querySelectorAll("[role=group] button")]).click();
    else if (field !== null && answers) {
      type.call(field, pick(answers));
      field.dispatchEvent(new Event("input", { bubbles: true }));
      await wait(5);
      if (field.getAttribute("role") === "combobox") press(field, "Enter");
      else if (field.getAttribute("aria-invalid") === "true") field.form.querySelector("button").click();
      else field.form.requestSubmit();
      await wait(0);
    }
    document.querySelector("dialog[open]")?.close();
    await wait(random() < 0.3 ? 0 : random() * 30);
  }
}

/** Runs in the page: what it shows, and what the server has. */
async function seen(task) {
  const answer = await fetch(`/api/document?path=${encodeURIComponent(task)}&since=0`);
  const { task: now, revision, text } = await answer.json();
  const rows = [...document.querySelectorAll('[role="treeitem"]')];
  return { ...window.wishes, revision, text, has: now.nodes.map((node) => node.path), shows: rows.map((row) => row.getAttribute("data-row")) };
}

await onPage(url, async (first, one) => {
  await onPage(url, async (second) => {
    const pages = [first, second];
    for (const page of pages) await words(page).choose("Task", task);
    for (const page of pages) await page.locator('[data-row="/"]').waitFor();
    for (const page of pages) await page.evaluate(count);
    /** Wait until nothing is under way, and both show what the server has. */
    const agree = async () => {
      let [deadline, sent] = [Date.now() + PATIENCE, 0];
      for (let calm = 0; Date.now() < deadline; ) {
        const all = await Promise.all(pages.map((page) => page.evaluate(seen, task)));
        const agreed = all.every((each) => each.open === 0 && each.revision === all[0].revision && JSON.stringify(each.has) === JSON.stringify(each.shows));
        calm = agreed ? calm + 1 : 0;
        if (calm === 3) return all;
        const now = all[0].sent + all[1].sent;
        if (now > sent) [deadline, sent] = [Date.now() + PATIENCE, now];
        await first.waitForTimeout(50);
      }
      for (const { has, shows } of await Promise.all(pages.map((page) => page.evaluate(seen, task)))) assert.deepEqual(shows, has);
      assert.fail("the pages find no rest");
    };
    let all = await agree();
    for (let round = 0; all[0].sent + all[1].sent < edits; round++) {
      await Promise.all(pages.map((page, at) => page.evaluate(gestures, { seed: seed + 2 * round + at, count: BETWEEN })));
      all = await agree();
      assert.ok(all.every((each) => each.sent > each.refused), "both pages edit");
    }
    // The text that each page has put together of changes is the server's.
    const { text } = all[0];
    for (const page of pages) {
      await words(page).button("Text").click();
      await page.locator(".cm-line").first().waitFor();
      // Without the first line: the one with the cursor is drawn also where the text below it is scrolled out of sight.
      const shown = async () => (await page.locator(".cm-line").allTextContents()).slice(1, 20).join("\n");
      await eventually(shown, (lines) => lines !== "" && text.includes(lines), `it isn't in ${text}`);
    }
    await one.button("Tree").click();
    await first.keyboard.press("Control+s");
    await one.fileIs("saved");
    // Everything is undone to the very bytes, where the history still reaches them. An answer may disable the button before it is pressed.
    while (edits <= REACH && (await one.button("Undo").isEnabled())) await one.button("Undo").click({ force: true });
    await first.keyboard.press("Control+s");
    await one.fileIs("saved");
    await agree();
    console.log(JSON.stringify({ edits: all[0].sent + all[1].sent, refused: all[0].refused + all[1].refused }));
  }, { expected: /status of 4(00|09)/ });
}, { expected: /status of 4(00|09)/ });
