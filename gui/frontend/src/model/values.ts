/** Literals as a person types them, and back. */

/** A value as it stands in a field: texts of text parameters as they are, everything else as JSON. */
export function valueText(value: unknown, type: string): string {
  if (value === undefined) return "";
  return typeof value === "string" && isText(type) ? value : JSON.stringify(value);
}

export function isText(type: string): boolean {
  return type === "str" || type === "text" || type === "expression" || type === "variable" || type === "child";
}

export type Parsed = { readonly value: unknown } | { readonly fault: string };

/** The value that a text stands for, or why it stands for none. */
export function parseValue(text: string, type: string): Parsed {
  if (isText(type)) return { value: text };
  const plain = text.trim();
  if (type === "int" || type === "float") {
    const number = Number(plain);
    if (plain === "" || !Number.isFinite(number) || (type === "int" && !Number.isInteger(number))) {
      return { fault: type === "int" ? "A whole number is needed." : "A number is needed." };
    }
    return { value: number };
  }
  try {
    return { value: JSON.parse(plain) };
  } catch {
    // A word where anything may stand is a text: `home` needs no quotes.
    if (/^[A-Za-z_][\w ./-]*$/.test(plain) && type !== "json") return { value: plain };
    return { fault: `A literal of type ${type} is needed, as JSON: 1, "text", [1, 2], {"a": 1}.` };
  }
}
