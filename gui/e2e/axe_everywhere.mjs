// No violation of WCAG 2.2 AA that axe can find on any page and in any state that isn't looked at elsewhere, in light and dark.
import { check } from "./axe.mjs";
import { onPage, url } from "./page.mjs";

for (const colorScheme of ["light", "dark"]) {
  await onPage(
    url,
    async (page, { button, choose, item, nodeIs, pick, runIs }) => {
      const look = (where) => check(page, `${colorScheme}, ${where}`);

      // The project's pages: each file, each tool, and what is said when there is nothing or something is wrong.
      await button("Project").click();
      await page.getByRole("group", { name: "Form" }).waitFor();
      await look("robot, sensors, processes");
      for (const name of ["Planners and kinematics", "Sensors"]) {
        await page.getByRole("button", { name: new RegExp(`^${name}`) }).click();
        await page.getByRole("toolbar", { name: "File" }).getByText(name, { exact: true }).waitFor();
        await look(name);
      }
      await page.getByRole("button", { name: /^Robot, sensors/ }).click();
      await page.getByLabel("Insert a template").selectOption("Panda with an Allegro hand");
      await page.getByLabel("Insert a template").selectOption("an arm with a hand");
      await page.getByRole("list", { name: "Problems of the file" }).waitFor();
      await look("a file with faults");
      const open = (name) => page.getByRole("navigation", { name: "Files of the project" }).getByRole("button", { name: new RegExp(`^${name}`) }).click();
      await open("Named poses");
      await page.getByRole("dialog").waitFor();
      await look("question: what to do with what isn't saved");
      await page.keyboard.press("ArrowDown");
      await page.keyboard.press("Enter");
      await page.getByText("messages/poses.yaml").first().waitFor();
      await page.getByLabel("Insert a template").selectOption("a pose");
      await page.getByText("not saved", { exact: true }).waitFor();
      await look("named poses");
      await open("Named joint states");
      await page.getByRole("dialog").waitFor();
      await page.keyboard.press("ArrowDown");
      await page.keyboard.press("Enter");
      await page.getByRole("main", { name: "Named joint states" }).waitFor(); // or else it's asked once more
      for (const name of ["Named joint states", "Named trajectories"]) {
        await open(name);
        await page.getByRole("main", { name }).waitFor();
        await look(name);
      }
      for (const name of ["Topics", "Message server", "New component", "Import a task"]) {
        await open(name);
        await page.getByRole("main", { name }).getByRole("heading").first().waitFor();
        await look(name);
      }
      await page.getByRole("button", { name: /^New component/ }).click();
      await page.getByLabel("Interface", { exact: true }).fill("no such thing");
      await page.getByRole("alert").getByText("isn't the name of an interface").waitFor();
      await look("an interface that is none");
      await button("Cancel").click();

      // The task: lists, questions, a run that holds, values, a record that is looked at.
      await button("Tasks").click();
      await choose("Task", "tasks/short.yaml");
      await choose("Robot", "fake");
      await nodeIs("machine", "not started");
      await pick("machine");
      for (const [key, what] of [["Control+f", "search"], ["k", "kinds"], ["w", "wrap"], ["Shift+K", "conversion"], ["Shift+E", "extract"], ["c", "connect"]]) {
        await item(what === "connect" ? "a" : "machine").focus();
        if (what === "connect") await pick("a");
        await page.keyboard.press(key);
        await page.getByRole("dialog").waitFor();
        await look(`question: ${what}`);
        await page.keyboard.press("Escape");
        await page.getByRole("dialog").waitFor({ state: "detached" });
      }
      await pick("second");
      await page.keyboard.press("F9");
      await page.getByRole("tab", { name: "Breakpoints" }).click();
      await page.getByLabel("Condition at attempts/second").waitFor();
      await look("breakpoints");
      await page.keyboard.press("Alt+r");
      await runIs("paused before attempts/second (breakpoint)");
      await look("a run that holds");
      await page.keyboard.press("Alt+p");
      await runIs("success: success");
      await page.getByRole("row", { name: /reached/ }).getByRole("button", { name: "2", exact: true }).click();
      await page.locator(".value-preview").waitFor();
      await page.getByRole("slider", { name: "Moment of the run" }).focus();
      await page.keyboard.press("Home");
      await look("a record at its beginning");
      await button("Robot in 3D").click();
      await page.getByLabel("What is drawn").waitFor();
      await look("no robot");
      await button("Close").click();
      await button("Edit the task").click();
      await pick("second");
      await page.keyboard.press("F9");
      await page.getByRole("button", { name: "reached", exact: true }).first().click();
      await look("the uses of a variable");

      // A second one looks on.
      const other = await page.context().newPage();
      await other.goto(page.url());
      await other.getByRole("tree").waitFor();
      await page.bringToFront(); // behind another page it gets little of a busy machine
      await page.getByRole("list", { name: "Who looks on" }).waitFor();
      await look("two look on");
    },
    // What isn't the name of an interface is refused (400), and the page says why.
    { colorScheme, reducedMotion: "reduce", expected: /status of 4(00|09)/ },
  );
}
