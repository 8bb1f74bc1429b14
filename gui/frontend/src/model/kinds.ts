/** The kinds of containers, as the server describes them: they are the same as long as the page is open. */
import type { SettingView, KindView } from "../protocol/generated";

let faces: ReadonlyMap<string, KindView> = new Map();

export function setKinds(kinds: readonly KindView[]): void {
  faces = new Map(kinds.map((face) => [face.kind, face]));
}

export const kinds = (): readonly KindView[] => [...faces.values()];
export const kindOf = (kind: string): KindView | undefined => faces.get(kind);
export const kindTitle = (kind: string): string => faces.get(kind)?.title ?? kind;
/** Whether its children's own outcomes say who is next. */
export const hasEdges = (node: { readonly kind: string } | undefined): boolean => node !== undefined && faces.get(node.kind)?.edges === true;
/** The kind in which edges stand. */
export const edgedKind = (): string => kinds().find((face) => face.edges)?.kind ?? "";

/** The settings that a container of a kind needs around these children. */
export function settingsFor(kind: string, children: readonly string[]): Record<string, unknown> {
  const face = faces.get(kind);
  const first = children[0] ?? "";
  const made: Record<string, unknown> = { ...face?.blank };
  const naming = (type: SettingView["type"]): readonly SettingView[] => (face?.fields ?? []).filter((field) => field.required && field.type === type);
  for (const field of naming("child")) made[field.key] = first;
  for (const field of naming("cases")) made[field.key] = first === "" ? {} : { [first]: 0 };
  return made;
}

/** An empty container as it stands in a file. One that needs a child begins with a child that does nothing. */
export function newContainer(kind: string): Record<string, unknown> {
  const face = faces.get(kind);
  if (face === undefined || face.holds === "none") return { kind, ...face?.blank };
  const step = { node: "flow/succeed", ...(face.edges ? { on: { success: "success" } } : {}) };
  const children = face.needs_child ? { step } : {};
  return { kind, ...settingsFor(kind, Object.keys(children)), [face.holds === "one" ? "child" : "children"]: children };
}
