/** What other people have selected: which of them are drawn at a node. */
import type { Viewer, Selected } from "../protocol/generated";

export type Selections = Readonly<Record<string, Selected>>;

/** What changed is taken over; pages with nothing selected go. */
export function taken(before: Selections, news: Readonly<Record<string, Selected | null>>): Selections {
  const now: Record<string, Selected> = { ...before };
  for (const [page, selected] of Object.entries(news)) {
    if (selected) now[page] = selected;
    else delete now[page];
  }
  return now;
}

/** The pages that have a node selected, or something in it that isn't drawn because it is `folded`. */
export function pagesAt(selections: Selections, task: string, path: string, folded: boolean): string[] {
  const isHere = (node: string): boolean => node === path || (folded && isInside(node, path));
  return Object.keys(selections).filter((page) => selections[page]?.task === task && selections[page].nodes.some(isHere));
}

function isInside(node: string, container: string): boolean {
  return node !== container && (container === "/" || node.startsWith(`${container}/`));
}

/** Paths as a page tells them, the one with the focus first: no more than the server takes. */
export function toTell(focus: string | null, marked: ReadonlySet<string>): string[] {
  const told: string[] = [];
  let room = LONGEST;
  for (const path of new Set([...(focus === null ? [] : [focus]), ...marked])) {
    room -= JSON.stringify(path).length + 1;
    if (told.length === MOST || room < 0) break;
    told.push(path);
  }
  return told;
}

/** The server takes 64 nodes, and messages of 4096 characters. */
const MOST = 64;
const LONGEST = 2900;

/** `Viewer 2` -> V2, `Ann Lee` -> AL, `Bob` -> Bo. */
export function initials(name: string): string {
  const words = name.split(" ").filter(Boolean);
  if (words.length < 2) return [...(words[0] ?? "?")].slice(0, 2).join("");
  return [words[0], words.at(-1)].map((word) => [...(word ?? "")][0] ?? "").join("").toUpperCase();
}

/** Who has something selected, in words. */
export function selectedBy(people: readonly Viewer[]): string {
  return `selected by ${people.map((each) => each.name).join(", ")}`;
}
