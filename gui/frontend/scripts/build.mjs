// Builds the page, says what it was made from and whose software it holds, and puts it where it is served.
import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { build } from "vite";

import { putInPlace } from "./put_in_place.mjs";
import { sourceHash } from "./source_hash.mjs";

const root = dirname(dirname(fileURLToPath(import.meta.url)));

function licenceOf(folder) {
  const file = readdirSync(folder).find((name) => /^(licen[cs]e|copying)/i.test(name));
  return file ? readFileSync(join(folder, file), "utf8").trim() : "(no licence file in the package)";
}

function notices() {
  const { packages } = JSON.parse(readFileSync(join(root, "package-lock.json"), "utf8"));
  const shipped = Object.entries(packages)
    .filter(([path, entry]) => path && !entry.dev && !entry.devOptional && !entry.optional)
    .map(([path]) => ({ path, ...JSON.parse(readFileSync(join(root, path, "package.json"), "utf8")) }))
    .filter((entry) => !entry.name.startsWith("@types/"))
    .sort((a, b) => (a.path < b.path ? -1 : 1));
  const parts = shipped.map((entry) => `${entry.name} ${entry.version} (${entry.license})\n\n${licenceOf(join(root, entry.path))}\n`);
  return `The editor's page contains the following software.\n\n${parts.join(`\n${"-".repeat(78)}\n\n`)}`;
}

// A folder of its own: the page stays served while it is built again, and two builds at a time don't mix.
const out = mkdtempSync(join(tmpdir(), "grip-page-"));
try {
  await build({ root, build: { outDir: out, emptyOutDir: true } });
  writeFileSync(join(out, "THIRD_PARTY_NOTICES.txt"), notices());
  writeFileSync(join(out, "build-info.json"), `${JSON.stringify({ source: sourceHash(root) }, null, 2)}\n`);
  putInPlace(out, join(root, "../grip_gui/static"));
} finally {
  rmSync(out, { recursive: true });
}
