/** Topics of the running ROS graph, where a project's file names some. */
import type { TopicView } from "../protocol/generated";
import type { Key } from "./shapes";

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
