// What runs beside the editor: topics with a message of each kind, a live server of messages, a component with a sample.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";

import { check } from "./axe.mjs";
import { eventually, onPage, rest, url } from "./page.mjs";

const [folder, shots] = rest;
const file = (path) => readFileSync(join(folder, path), "utf8");

for (const colorScheme of ["light", "dark"]) {
  await onPage(
    url,
    async (page, { button, answer }) => {
      const shot = (name) => (shots ? page.screenshot({ path: join(shots, `${name}-${colorScheme}.png`) }) : undefined);
      const topics = page.getByRole("list", { name: "Topics" });
      const received = page.getByRole("status", { name: "Received message" });
      await button("Project").click();
      await page.getByRole("button", { name: /^Topics/ }).click();

      // A topic by keys alone; a cloud and an image as pictures, anything else as its fields.
      await topics.getByText("/words").waitFor();
      await topics.getByRole("button", { name: /\/words/ }).focus();
      await page.keyboard.press("Enter");
      await button("Receive one message").focus();
      await page.keyboard.press("Enter");
      await received.getByText("data: hello").waitFor();
      for (const [name, picture] of [["/camera/points", /50 points from above/], ["/camera/color", /8 x 6 pixels/]]) {
        await topics.getByRole("button", { name: new RegExp(name) }).click();
        await button("Receive one message").click();
        await received.getByRole("img", { name: picture }).waitFor();
        await shot(name.replaceAll("/", "-"));
      }
      // Its picture, again and again.
      await page.getByLabel("Live", { exact: true }).check();
      await page.getByText("/camera/color, live").waitFor();
      await page.getByLabel("Live", { exact: true }).uncheck();
      await received.getByRole("img").waitFor();
      await check(page, `${colorScheme}, topics`);
      await page.getByLabel("Filter topics").fill("points");
      await topics.getByText("/words").waitFor({ state: "detached" });

      // The server of messages: live, also of what others do.
      await page.getByRole("button", { name: /^Message server/ }).click();
      await page.getByText("No server:").waitFor();
      await button("Serve the project's messages").click();
      const poses = page.getByRole("list", { name: "Messages in poses" });
      const pose = (name) => poses.getByRole("button", { name: new RegExp(`^${name} `) });
      await pose("bin").waitFor();
      await button("Add").click();
      await page.getByLabel("Name", { exact: true }).first().waitFor();
      await page.getByRole("group", { name: "New message" }).getByLabel("Name").fill("shelf");
      const text = page.getByLabel("Value (YAML)");
      await text.fill((await text.inputValue()).replace("z: 0.2", "z: nothing"));
      await button("Add it").click();
      await page.getByRole("alert").getByText("a valid number").waitFor();
      await text.fill((await text.inputValue()).replace("z: nothing", "z: 1.25"));
      await button("Add it").click();
      await page.getByRole("group", { name: "Message shelf" }).getByText("at (0.4, 0, 1.25) m in world").first().waitFor();
      await shot("messages");
      await text.fill((await text.inputValue()).replace("1.25", "1.5"));
      await button("Change it").click();
      await page.getByRole("group", { name: "Message shelf" }).getByText("at (0.4, 0, 1.5) m in world").first().waitFor();
      await check(page, `${colorScheme}, messages`);
      await button("Delete shelf from poses").click();
      await page.getByRole("dialog").waitFor();
      await page.keyboard.press("Enter");
      await pose("shelf").waitFor({ state: "detached" });

      if (colorScheme === "dark") {
        await button("Stop serving").click();
        await page.getByText("No server:").waitFor();
        await page.getByRole("button", { name: /^Component switcher/ }).click();
        await button("Call it once").waitFor();
        await check(page, "dark, component");
        return;
      }

      // Where the robot is.
      await page.getByLabel("Measured at").selectOption("the fake");
      await page.getByLabel("What", { exact: true }).selectOption("the pose of its grasp frame");
      await page.getByRole("group", { name: "Where the robot is" }).getByLabel("Name").fill("here");
      await button("Measure and save").click();
      await page.getByLabel("Result").getByText("the server has it").waitFor();
      await pose("here").waitFor();
      assert.match(file("messages/poses.yaml"), /here:/);
      await button("Stop serving").click();
      await page.getByText("No server:").waitFor();

      // A component, with what was typed and with what was recorded.
      await page.getByRole("button", { name: /^Component switcher/ }).click();
      const tried = page.getByRole("group", { name: "Try it with a sample" });
      await tried.getByLabel("data as YAML").fill("false");
      await button("Call it once").click();
      await tried.getByText("refused").waitFor();
      await tried.getByText("switched off").first().waitFor();
      await tried.getByLabel("data bool").selectOption({ index: 1 });
      await button("Call it once").click();
      await tried.getByText("switched on").first().waitFor();
      await tried.getByRole("term").getByText("message").waitFor();
      await shot("component");
      await check(page, "component");

      // A topic becomes a sensor, whose topic is completed from what runs.
      await page.getByRole("button", { name: /^Topics/ }).click();
      await topics.getByRole("button", { name: /\/camera\/points/ }).click();
      await page.getByLabel("Sensor", { exact: true }).fill("overhead_depth");
      await page.getByLabel("Output", { exact: true }).fill("cloud");
      await button("Put it into grip.yaml").click();
      const form = page.getByRole("group", { name: "Form" });
      await form.getByRole("group", { name: "sensors overhead_depth" }).getByLabel("topic", { exact: true }).waitFor();
      await form.getByText("Nothing is wrong").waitFor();
      await shot("sensor");
      await eventually(() => page.locator("datalist option[value='/camera/color']").count(), (count) => count > 0, "topics are offered");
    },
    { colorScheme, reducedMotion: "reduce" },
  );
}
