/** The focus, from panel to panel: a person without a mouse needn't pass by everything in between. */

/** What takes the focus in a panel first: what is chosen in a tree, then a field, then anything. */
const STARTS = ['[role="treeitem"][tabindex="0"]', '[aria-current="page"]', "input, select, textarea", "button, a[href], [tabindex='0']"];

function startOf(panel: Element): HTMLElement | undefined {
  for (const selector of STARTS) {
    const found = [...panel.querySelectorAll<HTMLElement>(selector)].find((each) => !each.matches(":disabled") && each.offsetParent !== null);
    if (found !== undefined) return found;
  }
  return undefined;
}

/** Panels in the order of the page, and those that can take the focus alone. */
function panels(): [Element, HTMLElement][] {
  return [...document.querySelectorAll(".bar, .panel, main, [role=tablist]")]
    .filter((each) => each.parentElement?.closest(".panel, main") === null)
    .flatMap((panel) => {
      const start = startOf(panel);
      return start === undefined ? [] : [[panel, start] as [Element, HTMLElement]];
    });
}

/** Go to the next panel, or with -1 to the one before; behind the last is the first. */
export function goToPanel(by: 1 | -1): void {
  const all = panels();
  const at = all.findIndex(([panel]) => panel.contains(document.activeElement));
  const next = at < 0 ? 0 : (at + by + all.length) % all.length;
  all[next]?.[1].focus();
}

/** After something was made from the bar above, or from nowhere: the keys that follow are about what was made. */
export function goToTree(): void {
  // The dialog that asked gives the focus back first.
  setTimeout(() => {
    const { activeElement } = document;
    if (activeElement !== document.body && activeElement?.closest(".bar") == null) return;
    document.querySelector<HTMLElement>('[role="tree"] [role="treeitem"][tabindex="0"]')?.focus({ preventScroll: true });
  });
}
