/** What a project needs to run a task, what it has of that, and what a node lacks. */
import type { NamedPlace, SceneItem, TopicView } from "../protocol/generated";
import type { Key } from "./shapes";

/** What a project needs to run a task. */
export interface Part {
  readonly what: "robot" | "arms" | "hands" | "sensors" | "world" | "tasks";
  readonly title: string;
  /** What there is of it. */
  readonly names: readonly string[];
}

/** What a project's `grip.yaml` and its tasks say of what is needed. */
export function partsOf(data: unknown, tasks: readonly string[]): Part[] {
  const file = (typeof data === "object" && data !== null ? data : {}) as Record<string, unknown>;
  const keys = (value: unknown): string[] => (typeof value === "object" && value !== null ? Object.keys(value) : []);
  const { robot, world } = file;
  return [
    { what: "robot", title: "Robot", names: robotNames(robot) },
    { what: "arms", title: "Arms", names: keys(file.arms) },
    { what: "hands", title: "Hands", names: keys(file.hands) },
    { what: "sensors", title: "Cameras and sensors", names: keys(file.sensors) },
    { what: "world", title: "World", names: typeof world === "string" ? [world] : [] },
    { what: "tasks", title: "Tasks", names: tasks.map((path) => path.replace(/^tasks\/|\.ya?ml$/g, "")) },
  ];
}

function robotNames(robot: unknown): string[] {
  if (typeof robot !== "object" || robot === null) return typeof robot === "string" ? [robot] : [];
  const { arm, hand, ready } = robot as Record<string, unknown>;
  if (typeof arm === "string" && typeof hand === "string") return [`${arm} with ${hand}`];
  return Object.keys(robot).length === 0 ? [] : [typeof ready === "string" ? ready : "from files"];
}

/** The task that shows most: the one in which the hand holds something, if there is one. */
export function firstTask(tasks: readonly string[]): string | undefined {
  return tasks.find((path) => path === "tasks/take.yaml") ?? tasks[0];
}

/** Which nodes need which part, and what one of it is called. */
export const NEEDS: readonly [RegExp, Part["what"], string][] = [
  [/^(arm|grasp)\//, "arms", "arm"],
  [/^hand\//, "hands", "hand"],
  [/^sensor\//, "sensors", "camera"],
];

/** What a node needs that the project doesn't have. */
export function lackingFor(node: string, parts: readonly Part[]): { what: Part["what"]; word: string } | null {
  const [, what, word] = NEEDS.find(([pattern]) => pattern.test(node)) ?? [];
  const there = parts.find((part) => part.what === what)?.names.length ?? 0;
  return what === undefined || word === undefined || there > 0 ? null : { what, word };
}

/** Stands in the palette for a component that isn't there yet. */
export const NEW_COMPONENT = "component/";
/** A camera of the world, for a project that has no sensor yet. */
export const NEW_CAMERA = "sensor/overhead";

/** What the palette offers to make besides what is there. */
export function toBeMade(nodes: readonly { id: string }[]): { id: string; doc: string }[] {
  const camera = nodes.some((face) => face.id.startsWith("sensor/")) ? [] : [{ id: NEW_CAMERA, doc: "The project has no camera yet: one is added." }];
  return [...camera, { id: NEW_COMPONENT, doc: "Software of others as a node: made of a .srv or .action." }];
}

/** Something of a world, as its file says it; lengths in m. */
export interface Thing {
  readonly kind: "fixtures" | "regions" | "objects";
  readonly name: string;
  /** The middle of its underside. */
  readonly at: readonly [number, number, number];
  /** Along x and y, before it is turned. */
  readonly size: readonly [number, number];
  readonly high: number;
  readonly yaw: number;
  readonly round: boolean;
}

/** What a thing is called among all of its world, such as "object mug". */
export const nameOf = ({ kind, name }: Thing): string => `${kind.slice(0, -1)} ${name}`;

/** Things as they are drawn in 3D; what the file says nothing of is as wide and as high as things of the library are. */
export function sceneOf(things: readonly Thing[]): Record<string, SceneItem> {
  const items = things.map((thing): [string, SceneItem] => {
    const { kind, at: [x, y, z], size: [a, b], high, yaw, round } = thing;
    const at = [x, y, z + high / 2, Math.cos(yaw / 2), 0, 0, Math.sin(yaw / 2)];
    return [nameOf(thing), { kind: round ? "cylinder" : "box", size: round ? [a / 2, high] : [a, b, high], body: "", at, hand: "", fixed: kind !== "objects" }];
  });
  return Object.fromEntries(items);
}

/** The poses of a file of named poses, also those of several end effectors under one name; what isn't whole yet is left out. */
export function posesOf(data: unknown): NamedPlace[] {
  const entries = (value: unknown): [string, Record<string, unknown>][] => Object.entries((typeof value === "object" && value !== null ? value : {}) as Record<string, Record<string, unknown>>).filter(([, each]) => typeof each === "object" && each !== null);
  return entries(data).flatMap(([name, said]) => {
    const frame = typeof said.reference_frame === "string" ? said.reference_frame : "world";
    const all: [string, Record<string, unknown>][] = "position" in said ? [[name, said]] : entries(said).map(([part, pose]) => [`${name}/${part}`, pose]);
    return all.flatMap(([of, { position, orientation }]) => {
      const [at, turn] = [position, orientation].map((each) => (each ?? {}) as Record<string, unknown>) as [Record<string, unknown>, Record<string, unknown>];
      const turned = "r" in turn ? turnOf(Number(turn.r), Number(turn.p), Number(turn.y)) : [turn.w, turn.x, turn.y, turn.z].map(Number);
      const numbers = [...[at.x, at.y, at.z].map(Number), ...turned];
      return numbers.every(Number.isFinite) ? [{ name: of, frame, at: numbers }] : [];
    });
  });
}

/** The joint states of a file of them: name -> joint -> position [rad or m]. */
export function standsOf(data: unknown): Record<string, Record<string, number>> {
  const known = Object.entries((typeof data === "object" && data !== null ? data : {}) as Record<string, unknown>);
  return Object.fromEntries(known.filter((each): each is [string, Record<string, number>] => typeof each[1] === "object" && each[1] !== null && Object.values(each[1]).every(Number.isFinite)));
}

/** The quaternion w x y z of a turn about the fixed axes x, y, z [rad]. */
function turnOf(roll: number, pitch: number, yaw: number): number[] {
  const [cr = 1, cp = 1, cy = 1] = [roll, pitch, yaw].map((angle) => Math.cos(angle / 2));
  const [sr = 0, sp = 0, sy = 0] = [roll, pitch, yaw].map((angle) => Math.sin(angle / 2));
  return [cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy];
}

/** How wide something is drawn whose file doesn't say it, such as an object of the library. */
const UNKNOWN = 0.07;
const UNKNOWN_HEIGHT = 0.1;

/** What of a world's file has a place, the largest first; what a seed draws into a region hasn't. */
export function thingsOf(data: unknown): Thing[] {
  const file = (typeof data === "object" && data !== null ? data : {}) as Record<string, unknown>;
  const numbers = (value: unknown): number[] => (Array.isArray(value) ? value.filter((each): each is number => typeof each === "number") : []);
  const one = (value: unknown): number | undefined => (typeof value === "number" ? value : numbers(value).at(-1));
  const found = (["fixtures", "regions", "objects"] as const).flatMap((kind) =>
    Object.entries((file[kind] ?? {}) as Record<string, Record<string, unknown> | null>).flatMap(([name, said]) => {
      const [x, y, z = 0] = numbers(said?.at ?? (kind === "fixtures" ? [0, 0, 0] : undefined));
      if (said === null || typeof said !== "object" || x === undefined || y === undefined) return [];
      const [a, b, c] = numbers(said.box ?? said.open_box ?? said.size);
      const radius = one(said.radius);
      const wide = radius === undefined ? (one(said.width) ?? UNKNOWN) : 2 * radius;
      const thing: Thing = { kind, name, at: [x, y, z], size: [a ?? wide, b ?? a ?? wide], high: c ?? one(said.height) ?? (radius === undefined ? UNKNOWN_HEIGHT : 2 * radius), yaw: one(said.yaw) ?? 0, round: kind === "objects" && said.shape !== "box" };
      return [thing];
    }),
  );
  return found.sort((one, other) => other.size[0] * other.size[1] - one.size[0] * one.size[1]);
}

const PICTURE = "sensor_msgs/msg/Image";
const GEOMETRY = "sensor_msgs/msg/CameraInfo";
/** Place in the file -> the type that a topic has to have there; any where it is empty. */
const PLACES: readonly (readonly [string, string])[] = [
  ["sensors/*/topics/*/topic", ""],
  ["ros/joint_states", "sensor_msgs/msg/JointState"],
  ["ros/controllers/*/positions", "std_msgs/msg/Float64MultiArray"],
  ["ros/cameras/*/image", PICTURE],
  ["ros/cameras/*/depth", PICTURE],
  ["ros/cameras/*/info", GEOMETRY],
];

/** The topics that may stand at a place; undefined where no topic stands, or nothing is known of any. */
export function topicsAt(topics: readonly TopicView[] | undefined, place: Key): readonly string[] | undefined {
  const found = PLACES.find(([pattern]) => {
    const steps = pattern.split("/");
    return steps.length === place.length && steps.every((step, at) => step === "*" || step === String(place[at]));
  });
  if (topics === undefined || found === undefined) return undefined;
  const fitting = topics.filter((topic) => found[1] === "" || topic.type === found[1]).map((topic) => topic.name);
  return fitting.length > 0 ? fitting : undefined;
}

export interface CameraTopics {
  readonly image: string;
  readonly depth: string;
  readonly info: string;
}

/** The topics of the RGB-D camera that a picture or a geometry belongs to, as drivers name them; what isn't found is empty. */
export function cameraOf(topic: TopicView, topics: readonly TopicView[]): CameraTopics | null {
  if (topic.type !== PICTURE && topic.type !== GEOMETRY) return null;
  const near = topics.filter((each) => each.name.split("/")[1] === topic.name.split("/")[1]);
  const pictures = near.filter((each) => each.type === PICTURE).map((each) => each.name);
  const chosen = topic.type === PICTURE ? topic.name : "";
  const isDepth = (name: string): boolean => /depth/.test(name);
  const image = chosen && !isDepth(chosen) ? chosen : (pictures.find((name) => !isDepth(name)) ?? "");
  const depths = pictures.filter((name) => isDepth(name) && name !== image);
  // Depth in the view of the colour camera, where a driver publishes both.
  const depth = chosen && isDepth(chosen) ? chosen : (depths.find((name) => /aligned|registered/.test(name)) ?? depths[0] ?? "");
  const beside = image.split("/").slice(0, -1).join("/");
  const infos = near.filter((each) => each.type === GEOMETRY).map((each) => each.name);
  const info = infos.find((name) => beside !== "" && name.startsWith(`${beside}/`)) ?? (topic.type === GEOMETRY ? topic.name : (infos[0] ?? ""));
  return { image, depth, info };
}
