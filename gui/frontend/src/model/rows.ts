/** Rules, cases and waits of containers as rows of a form, and what stands in the file for them. */

/** A rule of a parallel as it stands in a file. */
export interface Rule {
  readonly when?: Readonly<Record<string, string | readonly string[]>>;
  readonly at_least?: number;
  readonly ends?: "success" | "failure";
  readonly then: string;
}

export function rulesOf(value: unknown): readonly Rule[] {
  return Array.isArray(value) ? (value as Rule[]) : [];
}

/** The labels with which a child has to have ended for a rule to hold. */
export function labelsOf(rule: Rule, child: string): readonly string[] {
  const said = rule.when?.[child];
  return said === undefined ? [] : typeof said === "string" ? [said] : said;
}

/** A rule that looks at a child with these labels; with none it doesn't look at it. */
export function withLabels(rule: Rule, child: string, labels: readonly string[]): Rule {
  const { [child]: _, ...others } = rule.when ?? {};
  const before = Object.entries(rule.when ?? {});
  const said = labels.length === 1 ? (labels[0] as string) : labels;
  // A child that was looked at stays at its place.
  const there = before.some(([name]) => name === child);
  const when = labels.length === 0 ? others : there ? Object.fromEntries(before.map(([name, old]) => [name, name === child ? said : old])) : { ...others, [child]: said };
  return tidy({ ...rule, when });
}

/** A rule that counts children; without a number it doesn't. */
export function counting(rule: Rule, least: number | null, ends: "success" | "failure"): Rule {
  const { at_least: _, ends: __, ...others } = rule;
  return tidy(least === null ? others : { ...others, at_least: least, ends });
}

/** In the order in which people write it, without what says nothing. */
function tidy({ when, at_least, ends, then }: Rule): Rule {
  return {
    ...(when !== undefined && Object.keys(when).length > 0 ? { when } : {}),
    ...(at_least !== undefined ? { at_least } : {}),
    ...(at_least !== undefined && ends === "failure" ? { ends } : {}),
    then,
  };
}

/** The list with the entry at `at` moved by one place; the same where there is none. */
export function shifted<T>(list: readonly T[], at: number, by: -1 | 1): T[] {
  const moved = [...list];
  const to = at + by;
  if (to < 0 || to >= list.length) return moved;
  const [entry] = moved.splice(at, 1);
  moved.splice(to, 0, entry as T);
  return moved;
}

/** The literals of a case as a person types them: `1, 2, "a word"`. */
export function literalsText(said: unknown): string {
  return (Array.isArray(said) ? said : [said]).map((literal) => JSON.stringify(literal)).join(", ");
}

export type Literals = { readonly value: unknown } | { readonly fault: string };

/** What a typed list of literals stands for: one alone, or a list. A word needs no quotes. */
export function parseLiterals(text: string): Literals {
  const fault = 'Literals with commas between them are needed: 1, 2, "a word", true, null.';
  const read = (part: string): unknown => {
    try {
      return JSON.parse(part) as unknown;
    } catch {
      return /^[A-Za-z_][\w ./-]*$/.test(part) ? part : undefined;
    }
  };
  let values: unknown[];
  try {
    values = JSON.parse(`[${text}]`) as unknown[];
  } catch {
    values = text.split(",").map((part) => read(part.trim()));
  }
  const wrong = values.length === 0 || values.some((value) => value === undefined || (typeof value === "object" && value !== null));
  return wrong ? { fault } : { value: values.length === 1 ? values[0] : values };
}

/** Whom a parallel waits for, as a choice in a form. */
export type Wait = "" | "all" | "any" | "count" | "these";

export function waitOf(value: unknown): Wait {
  if (value === "all" || value === "any") return value;
  if (typeof value === "number") return "count";
  return Array.isArray(value) ? "these" : "";
}
