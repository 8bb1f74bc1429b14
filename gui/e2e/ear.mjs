// What a screen reader has to say: roles, names and states as Chromium's accessibility tree has them, and what live regions tell.

/** What is said of a property, where it is so. */
const STATES = { expanded: (value) => (value ? "expanded" : "collapsed"), selected: (value) => value && "selected", pressed: (value) => value === "true" && "pressed", invalid: (value) => value === "true" && "invalid", level: (value) => `level ${value}` };
const ROLES = { combobox: "combo box", treeitem: "tree item", textbox: "text field", spinbutton: "number field" };

/** In the page: what live regions tell, as it changes; each with its name, where it has one. */
function listen() {
  const LIVE = ":is([role=status], [role=alert], output, [aria-live]):not([aria-live=off])";
  const textOf = (node) => (node.nodeType === Node.TEXT_NODE ? node.data : node.ariaHidden === "true" ? "" : [...node.childNodes].map(textOf).join(""));
  window.grip_told = [];
  const last = new WeakMap();
  const look = () => {
    for (const region of document.querySelectorAll(LIVE)) {
      const text = textOf(region).replace(/\s+/g, " ").trim();
      if (text === (last.get(region) ?? "")) continue;
      last.set(region, text);
      if (text) window.grip_told.push([region.getAttribute("aria-label") ?? "", text]);
    }
  };
  new MutationObserver(look).observe(document, { subtree: true, childList: true, characterData: true });
  look();
}

export async function ear(page) {
  const devtools = await page.context().newCDPSession(page);
  await devtools.send("Accessibility.enable");
  await page.evaluate(listen);

  /** Role, name, value and states of an element. */
  async function said(expression) {
    const { result } = await devtools.send("Runtime.evaluate", { expression });
    if (!result.objectId) return "";
    const { nodes } = await devtools.send("Accessibility.getPartialAXTree", { objectId: result.objectId, fetchRelatives: false }).catch(() => ({ nodes: [] }));
    const [node] = nodes;
    if (!node || node.ignored) return "";
    const states = (node.properties ?? []).map(({ name, value }) => STATES[name]?.(value.value)).filter(Boolean);
    // When a problem is found depends on how busy the machine is.
    return [node.name?.value.replace(/\b(error|warning), /, ""), ROLES[node.role.value] ?? node.role.value, node.value?.value && `"${node.value.value}"`, ...states].filter(Boolean).join(", ");
  }
  return {
    /** What is said of where the focus is, and of the option that is chosen there. */
    spoken: async () => {
      const own = await said("document.activeElement");
      const option = await page.evaluate(() => document.getElementById(document.activeElement?.getAttribute("aria-activedescendant") ?? "")?.querySelector(".option-label")?.textContent);
      return option ? `${own}; ${option}, option` : own;
    },
    /** What live regions have told since this was asked last: `[name, text]` of each. */
    told: () => page.evaluate(() => window.grip_told.splice(0)),
  };
}
