// A capsule (`grip capsule`) in the system's Chromium, from a file: nodes light, keys work, nothing is asked of anybody.
import assert from "node:assert/strict";

import { chromium } from "playwright-core";

import { PATIENCE } from "./page.mjs";

const [url, shots = ""] = process.argv.slice(2);
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-dev-shm-usage"],
  timeout: PATIENCE,
});
try {
  for (const colorScheme of ["light", "dark"]) {
    const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, colorScheme, offline: true });
    context.setDefaultTimeout(PATIENCE);
    const page = await context.newPage();
    const complaints = [];
    const requests = [];
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
    page.on("request", (request) => requests.push(request.url()));
    await page.goto(url);
    await page.locator("html[data-ready]").waitFor();
    assert.equal(await page.locator("html").getAttribute("data-theme"), colorScheme);

    const words = () => page.locator("#words").textContent();
    const phase = (path, view = "tree") => page.locator(`#${view} [data-path="${path}"]`).getAttribute("data-phase");
    const slider = page.getByRole("slider", { name: "Moment of the run" });
    const count = Number(await slider.getAttribute("max"));
    assert.ok(count > 0);
    const settled = async (n) => {
      await page.waitForFunction((text) => document.getElementById("words").textContent.includes(text), `event ${n} of ${count}`);
    };
    // it opens at the end of the run
    await settled(count);
    assert.equal(await phase("/"), "success");
    assert.equal(await phase("attempts/broken"), "failure");
    assert.equal(await phase("machine/a", "flow"), "success");
    assert.match(await page.locator("#variables").textContent(), /reached2/);
    if (shots) await page.screenshot({ path: `${shots}/capsule_${colorScheme}.png` });

    // keys: to the beginning, then event by event, until the failing leaf has ended
    await slider.focus();
    await page.keyboard.press("Home");
    await settled(0);
    assert.equal(await phase("/"), "");
    for (let n = 1; n <= count && (await phase("attempts/broken")) !== "failure"; n++) {
      await page.keyboard.press("ArrowRight");
      await settled(n);
    }
    assert.equal(await phase("attempts"), "running");
    assert.equal(await phase("attempts/second"), "");
    assert.match(await page.locator("#events [aria-current]").textContent(), /attempts\/broken failure\.no_plan \(the way is blocked\)/);
    assert.match(await slider.getAttribute("aria-valuetext"), /attempts\/broken failure\.no_plan/);
    if (shots) await page.screenshot({ path: `${shots}/capsule_${colorScheme}_middle.png` });

    // a node by the keyboard, and what it says
    await page.getByLabel("Nodes").selectOption("attempts/broken");
    assert.match(await page.locator("#node").textContent(), /code: no_plan, message: the way is blocked/);
    assert.match(await page.locator("#node").textContent(), /✗ failure\.no_plan/);
    assert.match(await page.locator('#nodes option[value="attempts/broken"]').textContent(), /✗ failure/);

    // the other view, by mouse; a click on a node there chooses it
    await page.getByRole("tab", { name: "Flow" }).click();
    await page.locator('#flow [data-path="first"]').click();
    assert.equal(await page.getByLabel("Nodes").inputValue(), "first");
    if (shots) await page.screenshot({ path: `${shots}/capsule_${colorScheme}_flow.png` });

    // the time line, by pointer; play to the end; the other colours
    const spans = await page.locator("#spans").boundingBox();
    await page.mouse.click(spans.x + spans.width * 0.3, spans.y + 10);
    await page.waitForFunction(() => document.querySelector('#flow [data-path="first"]').dataset.phase === "running");
    await page.getByLabel("Speed").selectOption("100");
    await slider.focus();
    await page.keyboard.press("Space");
    await settled(count);
    await page.keyboard.press("t");
    assert.notEqual(await page.locator("html").getAttribute("data-theme"), colorScheme);
    assert.match(await page.locator("#text").textContent(), /kind: state_machine/);
    assert.match(await words(), /success/);

    assert.deepEqual(requests.filter((other) => other !== url && !other.startsWith("blob:")), []);
    assert.deepEqual(complaints, []);
    await context.close();
  }
} finally {
  await browser.close();
}
