import { describe, expect, it } from "vitest";
import { cameraOf, topicsAt } from "../src/model/parts";
import type { TopicView } from "../src/protocol/generated";

const PICTURE = "sensor_msgs/msg/Image";
const GEOMETRY = "sensor_msgs/msg/CameraInfo";

function topic(name: string, type: string): TopicView {
  return { name, type, value: type, publishers: 1 };
}

const DRIVER = [
  topic("/top/color/camera_info", GEOMETRY),
  topic("/top/color/image_raw", PICTURE),
  topic("/top/depth/camera_info", GEOMETRY),
  topic("/top/depth/image_rect_raw", PICTURE),
  topic("/top/aligned_depth_to_color/image_raw", PICTURE),
  topic("/side/color/image_raw", PICTURE),
  topic("/joint_states", "sensor_msgs/msg/JointState"),
];

describe("topics of a place", () => {
  it("are those of the type that the place has", () => {
    expect(topicsAt(DRIVER, ["ros", "cameras", "top", "info"])).toEqual(["/top/color/camera_info", "/top/depth/camera_info"]);
    expect(topicsAt(DRIVER, ["ros", "joint_states"])).toEqual(["/joint_states"]);
    expect(topicsAt(DRIVER, ["sensors", "any", "topics", "any", "topic"])).toHaveLength(DRIVER.length);
  });
  it("are left to other completion where no topic stands, or none is known", () => {
    expect(topicsAt(DRIVER, ["robot"])).toBeUndefined();
    expect(topicsAt(undefined, ["ros", "joint_states"])).toBeUndefined();
    expect(topicsAt(DRIVER, ["ros", "controllers", "arm", "positions"])).toBeUndefined();
  });
});

describe("a camera's topics", () => {
  const whole = { image: "/top/color/image_raw", depth: "/top/aligned_depth_to_color/image_raw", info: "/top/color/camera_info" };
  it.each(["/top/color/image_raw", "/top/aligned_depth_to_color/image_raw", "/top/depth/camera_info"])("are found from %s", (name) => {
    const chosen = DRIVER.find((each) => each.name === name);
    expect(chosen && cameraOf(chosen, DRIVER)).toEqual(whole);
  });
  it("are those that were chosen, where there are several", () => {
    expect(cameraOf(topic("/top/depth/image_rect_raw", PICTURE), DRIVER)?.depth).toBe("/top/depth/image_rect_raw");
  });
  it("stay empty where the driver has none", () => {
    expect(cameraOf(topic("/side/color/image_raw", PICTURE), DRIVER)).toEqual({ image: "/side/color/image_raw", depth: "", info: "" });
  });
  it("are none of what is no camera's", () => {
    expect(cameraOf(topic("/joint_states", "sensor_msgs/msg/JointState"), DRIVER)).toBeNull();
  });
});
