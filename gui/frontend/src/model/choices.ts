/** Choosing by keys among a few things that stand one below the other. */

/** So many are shown as buttons; more are a list that typing filters. */
export const FEW = 6;

/** Which one an arrow, Home or End leads to, from one to the next and round; null for any other key. */
export function turned(key: string, at: number, count: number): number | null {
  if (count === 0) return null;
  if (key === "ArrowDown" || key === "ArrowRight") return (at + 1) % count;
  if (key === "ArrowUp" || key === "ArrowLeft") return (Math.max(at, 0) + count - 1) % count;
  if (key === "Home") return 0;
  return key === "End" ? count - 1 : null;
}

/** The next one after `at` that begins with a letter; null where none does. */
export function startingWith(options: readonly { readonly label: string }[], key: string, at: number): number | null {
  if (key.length !== 1 || key.trim() === "") return null;
  const letter = key.toLowerCase();
  for (let step = 1; step <= options.length; step++) {
    const next = (at + step) % options.length;
    if (options[next]?.label.toLowerCase().startsWith(letter)) return next;
  }
  return null;
}
