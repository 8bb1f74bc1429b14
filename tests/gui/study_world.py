"""What the participants of the user study are given: a workspace of packages as laboratories have them, written afresh.

`python study_world.py FOLDER` writes it; the robots' shapes are those of the ready-made ones.
"""

from __future__ import annotations

import sys
from pathlib import Path
from textwrap import dedent
from xml.etree.ElementTree import Element, SubElement, fromstring, indent, tostring

from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.description.robot import RobotDescription

MANIFEST = (
    '<package format="3"><name>{name}</name><version>0.1.0</version><description>{doc}</description>{more}</package>\n'
)
LAUNCH = """\
<launch>
  <!-- The arm with the hand, as it stands in the laboratory. -->
  <arg name="robot_ip" default="10.0.0.2"/>
  <arg name="hand_id" default="rh"/>
  <include file="$(find-pkg-share lab_bringup)/launch/description.launch.xml"/>
  <node pkg="ur_robot_driver" exec="ur_ros2_control_node">
    <param name="robot_ip" value="$(var robot_ip)"/>
  </node>
</launch>
"""
DESCRIPTION = """\
<launch>
  <arg name="model" default="$(find-pkg-share lab_description)/urdf/ur10_shadow.urdf.xacro"/>
  <node pkg="robot_state_publisher" exec="robot_state_publisher">
    <param name="robot_description" value="$(command 'xacro $(var model) safety:=true')"/>
    <param name="robot_description_semantic"
      value="$(command 'cat $(find-pkg-share ur10_shadow_config)/config/ur10_shadow.srdf')"/>
  </node>
</launch>
"""
SERVICE = """\
# Where a gripper takes what the depth camera sees.
sensor_msgs/PointCloud2 cloud
---
bool success
geometry_msgs/PoseStamped best_grasp
float32 width
"""
SERVER = '''\
"""Offers the planner to others as a service."""

import numpy as np
import rclpy
from planar_grasps.srv import PlanGrasp
from planner import plan
from rclpy.node import Node


def points_of(cloud):
    at = {field.name: field.offset for field in cloud.fields}
    if not cloud.data:
        return np.zeros((0, 3))
    rows = np.frombuffer(cloud.data, np.uint8).reshape(-1, cloud.point_step)
    points = np.hstack([rows[:, at[axis] : at[axis] + 4].copy().view("<f4") for axis in "xyz"]).astype(float)
    return points[np.isfinite(points).all(axis=1)]


class GraspServer(Node):
    def __init__(self):
        super().__init__("planar_grasps")
        self.create_service(PlanGrasp, "/planar_grasps/plan", self.answer)

    def answer(self, request, response):
        found = plan(points_of(request.cloud))
        response.success = found is not None
        if found is not None:
            position, yaw, width = found
            at = response.best_grasp.pose
            response.best_grasp.header = request.cloud.header
            at.position.x, at.position.y, at.position.z = (float(each) for each in position)
            # The palm looks down, the fingers close across the thing.
            at.orientation.x, at.orientation.y = float(np.cos(yaw / 2)), float(np.sin(yaw / 2))
            at.orientation.z = at.orientation.w = 0.0
            response.width = float(width)
        return response


def main():
    rclpy.init()
    rclpy.spin(GraspServer())


if __name__ == "__main__":
    main()
'''
PLANNER = '''\
"""Planar grasps of the highest thing on a flat ground: across it, where it is narrowest."""

import numpy as np

GROUND, CEILING = 0.012, 0.2  # what is lower or higher is no thing [m]
DEPTH = 0.02  # how far the tips reach below the top [m]


def plan(points):
    """Return (position, yaw, width) [m, rad, m] of the best grasp, or None.

    `points` has shape (n, 3) in a frame whose z is up; the fingers close along the y of the grasp.
    """
    things = points[(points[:, 2] > GROUND) & (points[:, 2] < CEILING)]
    if len(things) < 20:
        return None
    top = things[np.argmax(things[:, 2])]
    thing = things[np.linalg.norm(things[:, :2] - top[:2], axis=1) < 0.1]
    best = None
    for yaw in np.arange(0, np.pi, np.pi / 36):
        along, across = (thing[:, :2] @ axis for axis in ((np.cos(yaw), np.sin(yaw)), (-np.sin(yaw), np.cos(yaw))))
        if best is None or np.ptp(across) < best[1]:
            middle = (along.min() + along.max()) / 2, (across.min() + across.max()) / 2
            best = yaw, np.ptp(across), middle
    yaw, width, (a, b) = best
    x, y = a * np.cos(yaw) - b * np.sin(yaw), a * np.sin(yaw) + b * np.cos(yaw)
    return (x, y, max(top[2] - DEPTH, 0.02)), yaw, width
'''
KINECT = '''\
"""Publishes what a Kinect 2 publishes, until it is ended: a wall 1.3 m away."""

import time

import numpy as np

from grip_bt.ros.client.bus import Bus
from grip_bt.ros.client.types import load_type

WIDTH, HEIGHT, FOCAL = 480, 270, 270.0
FRAME = "kinect2_rgb_optical_frame"
shade = np.tile(np.linspace(40, 220, WIDTH, dtype=np.uint8), (HEIGHT, 1))
Image, CameraInfo = load_type("sensor_msgs/msg/Image"), load_type("sensor_msgs/msg/CameraInfo")


def picture(encoding, pixels):
    message = Image(height=HEIGHT, width=WIDTH, encoding=encoding, step=pixels.nbytes // HEIGHT)
    message.header.frame_id, message.data = FRAME, pixels.tobytes()
    return message


info = CameraInfo(height=HEIGHT, width=WIDTH, distortion_model="plumb_bob", d=[0.0] * 5)
info.header.frame_id = FRAME
info.k = [FOCAL, 0.0, WIDTH / 2, 0.0, FOCAL, HEIGHT / 2, 0.0, 0.0, 1.0]
info.p = [FOCAL, 0.0, WIDTH / 2, 0.0, 0.0, FOCAL, HEIGHT / 2, 0.0, 0.0, 0.0, 1.0, 0.0]
told = {
    "image_color_rect": ("Image", picture("rgb8", np.stack([shade] * 3, axis=-1))),
    "image_depth_rect": ("Image", picture("16UC1", np.full((HEIGHT, WIDTH), 1300, np.uint16))),
    "camera_info": ("CameraInfo", info),
}
with Bus("kinect2") as bus:
    writers = {name: bus.writer(f"sensor_msgs/msg/{kind}", f"/kinect2/qhd/{name}") for name, (kind, _) in told.items()}
    while True:
        for name, (_, message) in told.items():
            writers[name].publish(message)
        time.sleep(0.5)
'''


def write_world(lab: Path) -> None:
    """Write the workspace: a MoveIt package, a launch file with what it brings up, a repository, a camera's driver."""
    _package(lab / "src/ur_description", "The UR5.", {"urdf/ur5.urdf": build_robot("ur5").urdf})
    ur5 = build_robot("ur5")
    moveit = {
        ".setup_assistant": "moveit_setup_assistant_config:\n"
        "  URDF: {package: ur_description, relative_path: urdf/ur5.urdf}\n"
        "  SRDF: {relative_path: config/ur5.srdf}\n",
        "config/ur5.srdf": srdf_of(ur5, {"arm": "manipulator"}),
        "config/kinematics.yaml": "manipulator:\n  kinematics_solver: kdl_kinematics_plugin/KDLKinematicsPlugin\n"
        "  kinematics_solver_search_resolution: 0.005\n  kinematics_solver_timeout: 0.005\n",
        "config/joint_limits.yaml": "joint_limits:\n"
        + "".join(f"  {joint}: {{has_velocity_limits: true, max_velocity: 3.15}}\n" for joint in ur5.groups["arm"]),
        "config/ompl_planning.yaml": "planner_configs:\n  RRTConnect: {type: geometric::RRTConnect}\n"
        "manipulator: {default_planner_config: RRTConnect, planner_configs: [RRTConnect]}\n",
    }
    _package(lab / "src/ur5_moveit_config", "MoveIt's configuration.", moveit, "<depend>ur_description</depend>")
    both = build_robot("ur10_shadow")
    _package(
        lab / "src/lab_description",
        "The UR10 with the Shadow hand.",
        {"urdf/ur10_shadow.urdf.xacro": _as_xacro(both)},
    )
    _package(
        lab / "src/ur10_shadow_config", "Its groups.", {"config/ur10_shadow.srdf": srdf_of(both, {}, "rh_manipulator")}
    )
    launch = {"launch/ur10_shadow.launch.xml": LAUNCH, "launch/description.launch.xml": DESCRIPTION}
    _package(lab / "src/lab_bringup", "Brings it up.", launch)
    grasps = {
        "srv/PlanGrasp.srv": SERVICE,
        "scripts/grasp_server.py": SERVER,
        "scripts/planner.py": PLANNER,
        "README.md": "# Planar grasps\n\nOne service, `/planar_grasps/plan`: a cloud whose z is up.\n",
    }
    _package(
        lab / "planar_grasps", "Planar grasps.", grasps, "<depend>sensor_msgs</depend><depend>geometry_msgs</depend>"
    )
    (lab / "kinect2.py").write_text(KINECT)


GREET = """\
---
bool success
string words
"""
GREETER = """\
import rclpy
from greeter.srv import Greet
from rclpy.node import Node


class Greeter(Node):
    def __init__(self):
        super().__init__("greeter")
        self.create_service(Greet, "/greeter/greet", self.answer)

    def answer(self, request, response):
        response.success, response.words = True, "hello"
        return response


rclpy.init()
rclpy.spin(Greeter())
"""


def write_greeter(lab: Path) -> None:
    """Write a repository whose service needs nothing and always succeeds."""
    _package(lab / "greeter", "Greets.", {"srv/Greet.srv": GREET, "scripts/greet_server.py": GREETER})


def srdf_of(robot: RobotDescription, renamed: dict[str, str], tip: str = "") -> str:
    """Return a robot's groups, states and ends as MoveIt's assistant writes them."""
    root = Element("robot", name=robot.name)
    name = {group: renamed.get(group, group) for group in robot.groups}
    for group, joints in robot.groups.items():
        each = SubElement(root, "group", name=name[group])
        for joint in joints:
            SubElement(each, "joint", name=joint)
    for group, states in robot.named_states.items():
        for state, at in states.items():
            each = SubElement(root, "group_state", name=state, group=name[group])
            for joint, position in at.as_mapping().items():
                SubElement(each, "joint", name=joint, value=f"{position:.6g}")
    for end in robot.end_effectors:
        SubElement(
            root,
            "end_effector",
            name=end.name,
            parent_link=tip or end.parent_link,
            group=name[end.group],
            parent_group=name[end.parent_group],
        )
    for one, other in sorted(robot.disabled_pairs):
        SubElement(root, "disable_collisions", link1=one, link2=other, reason="Never")
    indent(root)
    return tostring(root, encoding="unicode") + "\n"


def _as_xacro(robot: RobotDescription) -> str:
    """Return the URDF with an argument, and with the frame in which Shadow's packages give grasps."""
    root = fromstring(robot.urdf)
    root.set("xmlns:xacro", "http://www.ros.org/wiki/xacro")
    root.insert(0, Element("xacro:arg", {"name": "safety", "default": "false"}))
    frame = robot.grasp_frames["arm"]
    SubElement(root, "link", name="rh_manipulator")
    joint = SubElement(root, "joint", name="rh_manipulator_fixed", type="fixed")
    SubElement(joint, "parent", link=frame.link)
    SubElement(joint, "child", link="rh_manipulator")
    xyz = " ".join(f"{each:.6g}" for each in frame.pose.position)
    SubElement(joint, "origin", xyz=xyz, rpy="0 -1.570796 1.570796")  # z leaves the palm, x runs along the fingers
    return tostring(root, encoding="unicode") + "\n"


def _package(folder: Path, doc: str, files: dict[str, str], more: str = "") -> None:
    files = {"package.xml": MANIFEST.format(name=folder.name, doc=doc, more=more), **files}
    for path, text in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(dedent(text), encoding="utf-8")


if __name__ == "__main__":
    write_world(Path(sys.argv[1]))
