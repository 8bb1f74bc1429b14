// Puts a finished build where it is served, file by file: who reads meanwhile finds every file whole, old or new.
import { copyFileSync, mkdirSync, readdirSync, renameSync, rmSync } from "node:fs";
import { dirname, join, relative } from "node:path";

function filesOf(folder) {
  return readdirSync(folder, { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) => relative(folder, join(entry.parentPath, entry.name)));
}

/** Make `target` hold the files of `made` and no others. What names other files comes after them: the page, then what the build says of itself. */
export function putInPlace(made, target) {
  mkdirSync(target, { recursive: true });
  const rank = (name) => ["index.html", "build-info.json"].indexOf(name);
  const files = filesOf(made).sort((a, b) => rank(a) - rank(b));
  for (const name of files) {
    const place = join(target, name);
    const aside = `${place}.${process.pid}.new`;
    mkdirSync(dirname(place), { recursive: true });
    copyFileSync(join(made, name), aside);
    renameSync(aside, place); // one step, also for who has the file open
  }
  const known = new Set(files);
  for (const name of filesOf(target)) if (!known.has(name)) rmSync(join(target, name));
}
