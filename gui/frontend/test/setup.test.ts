import { beforeEach, expect, test, vi } from "vitest";

import { server } from "../src/protocol/client";
import type { SetupView } from "../src/protocol/generated";
import { openSetup, setValue, typeSetup, useSetup } from "../src/store/setup";

// There is no browser here; what the stores ask of one when they are loaded is nothing that these tests need.
vi.hoisted(() => {
  const kept = { getItem: () => null, setItem: () => undefined };
  Object.assign(globalThis, { sessionStorage: kept, localStorage: kept, location: new URL("http://127.0.0.1/"), window: globalThis });
});

const file = (path: string, text: string): SetupView => ({ path, text, known: text, title: path, kind: "project", data: {}, problems: [], templates: [], shape: {}, options: {} }) as unknown as SetupView;
const text = (): string | undefined => useSetup.getState().view?.text;
let answers: ((view: SetupView) => void)[];

beforeEach(() => {
  answers = [];
  vi.spyOn(server, "setupFile").mockImplementation(() => new Promise((answer) => answers.push(answer)));
  vi.spyOn(server, "setupCheck").mockImplementation((asked) => Promise.resolve(file(asked.path, asked.text)));
  vi.spyOn(server, "setupChange").mockImplementation((asked) => Promise.resolve(file(asked.path, `${asked.text}+`)));
  useSetup.setState({ view: file("grip.yaml", "old"), saved: "old", known: "old" });
});

/** Have everything happen that waits for nothing more. */
const passed = (): Promise<void> => new Promise((done) => setTimeout(done, 0));

test("what isn't saved of a file is kept when it is opened once more", async () => {
  await typeSetup("typed");
  await openSetup("grip.yaml");
  expect(text()).toBe("typed");
  expect(answers).toHaveLength(0);
});

test.each([["by a form", () => setValue(["robot"], "panda"), "old+"], ["by hand", () => typeSetup("typed"), "typed"]])("what is changed %s while the file is read again counts", async (_, change, expected) => {
  const opened = openSetup("grip.yaml");
  await passed();
  await change();
  answers[0]?.(file("grip.yaml", "old"));
  await opened;
  expect(text()).toBe(expected);
  expect(useSetup.getState().checking).toBe(false);
});

test("the file that was asked for last is shown, whichever answer comes first", async () => {
  const both = [openSetup("worlds/one.yaml"), openSetup("worlds/two.yaml")];
  await passed();
  answers[1]?.(file("worlds/two.yaml", "two"));
  await passed();
  answers[0]?.(file("worlds/one.yaml", "one"));
  await Promise.all(both);
  expect(text()).toBe("two");
});
