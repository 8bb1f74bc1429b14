// Last step of the build: says what the build was made from, and whose software it holds.
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

import { sourceHash } from "./source_hash.mjs";

const root = dirname(dirname(fileURLToPath(import.meta.url)));
const out = join(root, "../grip_gui/static");

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

writeFileSync(join(out, "THIRD_PARTY_NOTICES.txt"), notices());
writeFileSync(join(out, "build-info.json"), `${JSON.stringify({ source: sourceHash(root) }, null, 2)}\n`);
