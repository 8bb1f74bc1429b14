/** JSON Schema as far as forms need it: what a value is made of, and what may stand at a place. */

export interface Shape {
  readonly type?: string;
  readonly title?: string;
  readonly description?: string;
  readonly properties?: Readonly<Record<string, Shape>>;
  readonly required?: readonly string[];
  readonly additionalProperties?: Shape | boolean;
  readonly patternProperties?: Readonly<Record<string, Shape>>;
  readonly items?: Shape;
  readonly prefixItems?: readonly Shape[];
  readonly enum?: readonly unknown[];
  readonly const?: unknown;
  readonly anyOf?: readonly Shape[];
  readonly oneOf?: readonly Shape[];
  readonly allOf?: readonly Shape[];
  readonly default?: unknown;
  readonly minimum?: number;
  readonly $ref?: string;
  readonly $defs?: Readonly<Record<string, Shape>>;
}

export type Key = readonly (string | number)[];
export type FormKind = "fields" | "entries" | "list" | "items" | "choice" | "flag" | "number" | "text";

/** The shape that a value has, or would have: references followed, the fitting branch of several taken. */
export function resolved(shape: Shape, root: Shape, value: unknown): Shape {
  if (shape.$ref !== undefined) {
    const { $ref, ...beside } = shape;
    const target = root.$defs?.[$ref.split("/").at(-1) ?? ""] ?? {};
    return resolved({ ...target, ...beside }, root, value);
  }
  const branches = (shape.anyOf ?? shape.oneOf ?? shape.allOf)?.filter((branch) => branch.type !== "null");
  if (branches === undefined || branches.length === 0) return shape;
  const all = branches.map((branch) => resolved(branch, root, value));
  const fitting = all.find((branch) => fits(branch, value)) ?? all[0];
  const { anyOf: _, oneOf: __, allOf: ___, ...beside } = shape;
  return { ...fitting, ...beside };
}

function fits(shape: Shape, value: unknown): boolean {
  if (value === undefined || value === null) return false;
  if (Array.isArray(value)) return shape.type === "array";
  if (typeof value === "object") return shape.type === "object";
  if (typeof value === "number") return shape.type === "number" || shape.type === "integer";
  return shape.type === typeof value;
}

/** The shape of the values of a mapping whose keys are names that people give. */
export function entryShape(shape: Shape): Shape {
  if (typeof shape.additionalProperties === "object") return shape.additionalProperties;
  return Object.values(shape.patternProperties ?? {})[0] ?? {};
}

/** The shape at a place, as a mapping or a list that isn't there yet would have it. */
export function shapeAt(root: Shape, place: Key): Shape {
  const shape = place.reduce<Shape>((at, step) => {
    const exact = resolved(at, root, typeof step === "number" ? [] : {});
    return exact.properties?.[step] ?? exact.items ?? entryShape(exact);
  }, root);
  return resolved(shape, root, {});
}

/** Which kind of field a shape needs. */
export function formKind(shape: Shape): FormKind {
  if (shape.properties) return "fields";
  if (shape.type === "object") return "entries";
  if (shape.type === "array") return shape.items?.type === "object" || shape.items?.$ref !== undefined ? "items" : "list";
  if (shape.enum) return "choice";
  if (shape.type === "boolean") return "flag";
  if (shape.type === "number" || shape.type === "integer") return "number";
  return "text";
}

/** What may stand at a place; undefined where anything may. */
export function optionsAt(options: Readonly<Record<string, readonly string[]>>, key: Key): readonly string[] | undefined {
  const fitting = Object.keys(options).find((pattern) => {
    const steps = pattern.split("/");
    return steps.length === key.length && steps.every((step, at) => step === "*" || step === String(key[at]));
  });
  return fitting === undefined ? undefined : options[fitting];
}

/** Keys of values that are paths -> how such files end; a folder where nothing is said of that. */
const PATHS: Readonly<Record<string, RegExp | null>> = {
  urdf: /\.urdf$/,
  xacro: /\.xacro$/,
  srdf: /\.srdf(\.xacro)?$/,
  moveit: null,
  launch: /(launch\.(py|xml|yaml)|\.launch)$/,
  scene: /\.scene$/,
  nodes: null,
  components: null,
  folder: null,
  mesh: /\.(obj|stl|ply|dae)$/i,
  model: /\.yaml$/,
};

/** What may be browsed for at a place: how a file ends, null for a folder; undefined where no path stands. */
export function pathAt(place: Key): RegExp | null | undefined {
  const [key, above] = [place.at(-1), place.at(-2)].map(String);
  if (above === "packages") return null;
  return place[0] === "robot" && ["arm", "hand", "robot"].includes(key ?? "") ? /\.(urdf|xacro|yaml)$/ : PATHS[key ?? ""];
}

/** A path as it is said in a file of a folder; both begin at the root. */
export function pathFrom(folder: string, path: string): string {
  const [from = [], to = []] = [folder, path].map((each) => each.split("/").filter(Boolean));
  const apart = from.findIndex((step, at) => step !== to[at]);
  const shared = apart < 0 ? from.length : apart;
  return [...from.slice(shared).map(() => ".."), ...to.slice(shared)].join("/") || ".";
}

/** The value at a place of some data. */
export function valueAt(data: unknown, key: Key): unknown {
  return key.reduce<unknown>((at, step) => (typeof at === "object" && at !== null ? (at as Record<string | number, unknown>)[step] : undefined), data);
}

/** What a person typed into a list: values between commas, numbers as numbers where the list has them. */
export function listOf(text: string, numbers: boolean): unknown[] {
  const parts = text.split(",").map((part) => part.trim()).filter((part) => part !== "");
  return numbers ? parts.map((part) => (Number.isNaN(Number(part)) ? part : Number(part))) : parts;
}

/** A name that isn't taken yet: `right`, `right_2` ... */
export function freeName(wanted: string, taken: readonly string[]): string {
  let name = wanted;
  for (let number = 2; taken.includes(name); number++) name = `${wanted}_${number}`;
  return name;
}

/** Keys of the mapping at the place of a cursor, and the key before the cursor: for completion. */
export function keyBefore(text: string, cursor: number): Key {
  const lines = text.slice(0, cursor).split("\n");
  const last = lines.pop() ?? "";
  let indent = last.length - last.trimStart().length;
  const path: (string | number)[] = [];
  for (const line of lines.reverse()) {
    const own = line.length - line.trimStart().length;
    const key = /^\s*(?:- )?["']?([\w .-]+?)["']?:\s*(#.*)?$/.exec(line)?.[1];
    if (own < indent && key !== undefined) {
      path.unshift(key);
      indent = own;
    }
  }
  return [...path, ...keysInLine(last)];
}

function keysInLine(line: string): string[] {
  const open: string[] = [];
  let key = "";
  let word = "";
  for (const character of line) {
    if (character === ":") {
      key = word.trim().replace(/^["']|["']$/g, "");
      word = "";
    } else if (character === "{") {
      open.push(key);
      key = "";
      word = "";
    } else if (character === "}") {
      key = open.pop() ?? "";
    } else if (character === ",") {
      key = "";
      word = "";
    } else word += character;
  }
  return [...open, ...(key ? [key] : [])].filter((step) => step !== "");
}
