import { expect, test } from "vitest";

import { turned } from "../src/model/values";
import { isFew } from "../src/store/ask";

test("arrows lead from one to the next and round, Home and End to the ends", () => {
  expect(turned("ArrowDown", 0, 3)).toBe(1);
  expect(turned("ArrowDown", 2, 3)).toBe(0);
  expect(turned("ArrowUp", 0, 3)).toBe(2);
  expect(turned("ArrowUp", 2, 3)).toBe(1);
  expect(turned("ArrowDown", -1, 3)).toBe(0); // nothing has the focus yet
  expect(turned("ArrowUp", -1, 3)).toBe(2);
  expect(turned("Home", 2, 3)).toBe(0);
  expect(turned("End", 0, 3)).toBe(2);
  expect(turned("Enter", 0, 3)).toBeNull(); // which presses the button
  expect(turned("ArrowDown", -1, 0)).toBeNull();
});

test("a few choices are buttons, many are a list that is filtered, and a search always is", () => {
  const options = Array.from({ length: 7 }, (_, i) => ({ value: `${i}`, label: `${i}` }));
  expect(isFew({ options: options.slice(0, 2) })).toBe(true);
  expect(isFew({ options: options.slice(0, 6) })).toBe(true);
  expect(isFew({ options })).toBe(false);
  expect(isFew({ options: options.slice(0, 2), search: true })).toBe(false);
});
