import { readFileSync } from "node:fs";
import { expect, test } from "vitest";

/** Contrast of the colour tokens (WCAG 2.2, 1.4.3): browsers can't check it on the canvas. */
const css = readFileSync(new URL("../src/view/page.css", import.meta.url), "utf8");
const [light = "", rest = ""] = css.split("@media (prefers-color-scheme: dark)");
const [dark = ""] = rest.split(".phase-idle");
const bar = /^\.bar \{[^}]*\}/m.exec(rest)?.[0] ?? "";

function tokens(text: string): Record<string, string> {
  return Object.fromEntries([...text.matchAll(/--([\w-]+): (#[0-9a-f]{6})/g)].map((m) => [m[1], m[2]]));
}

function luminance(hex: string): number {
  const [r = 0, g = 0, b = 0] = [1, 3, 5]
    .map((i) => parseInt(hex.slice(i, i + 2), 16) / 255)
    .map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

function contrast(a: string, b: string): number {
  const [high = 0, low = 0] = [luminance(a), luminance(b)].sort((x, y) => y - x);
  return (high + 0.05) / (low + 0.05);
}

const SURFACES = ["page", "surface", "sunken", "running-soft", "success-soft", "failure-soft", "interrupted-soft", "error-soft", "select", "warn-soft"];

test.each([
  ["light", tokens(light)],
  ["dark", { ...tokens(light), ...tokens(dark) }],
])("text is readable on every surface (%s)", (_, colours) => {
  for (const text of ["text", "quiet"]) {
    for (const surface of SURFACES) {
      expect(contrast(colours[text] ?? "", colours[surface] ?? ""), `${text} on ${surface}`).toBeGreaterThanOrEqual(4.5);
    }
  }
  for (const phase of ["running", "success", "failure", "interrupted", "error"]) {
    for (const surface of ["surface", "sunken", `${phase}-soft`]) {
      expect(contrast(colours[phase] ?? "", colours[surface] ?? ""), `${phase} on ${surface}`).toBeGreaterThanOrEqual(4.5);
    }
  }
  for (let viewer = 0; viewer < 8; viewer++) {
    expect(contrast("#ffffff", colours[`viewer-${viewer}`] ?? ""), `initials of viewer ${viewer}`).toBeGreaterThanOrEqual(4.5);
    for (const surface of SURFACES) {
      const ring = contrast(colours[`viewer-line-${viewer}`] ?? "", colours[surface] ?? "");
      expect(ring, `ring of viewer ${viewer} on ${surface}`).toBeGreaterThanOrEqual(3);
    }
  }
  for (const surface of ["surface", "sunken", "warn-soft"]) expect(contrast(colours["warn"] ?? "", colours[surface] ?? ""), `warn on ${surface}`).toBeGreaterThanOrEqual(4.5);
  for (const name of ["accent", "stop", "brand"]) {
    expect(contrast(colours[`${name}-text`] ?? "", colours[name] ?? ""), name).toBeGreaterThanOrEqual(4.5);
  }
});

test("the bar is ink in both themes, and what it says can be read on it", () => {
  for (const theme of [tokens(light), { ...tokens(light), ...tokens(dark) }]) {
    const colours = { ...theme, ...tokens(bar) };
    for (const text of ["text", "quiet", "accent"]) {
      for (const surface of ["ink", "surface", "page", "sunken"]) expect(contrast(colours[text] ?? "", colours[surface] ?? ""), `${text} on ${surface}`).toBeGreaterThanOrEqual(4.5);
    }
    for (const phase of ["running", "success", "failure", "interrupted", "error"]) expect(contrast(colours[phase] ?? "", colours[`${phase}-soft`] ?? ""), phase).toBeGreaterThanOrEqual(4.5);
  }
});
