"""What a robot's driver says of itself beside its joints: its description, where its links are, and the time."""

from __future__ import annotations

import time
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from rclpy.qos import DurabilityPolicy, QoSProfile
from scipy.spatial.transform import Rotation

from grip_bt.base.arrays import Array
from grip_bt.base.errors import GripError
from grip_bt.base.ports import Executor
from grip_bt.base.values import Pose
from grip_bt.base.values.pose import quaternion_of
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.convert_geometry import header, pose_to_transform_stamped
from grip_bt.ros.interfaces.build import ensure_package
from grip_bt.ros.served import Published

from .client.types import Message, load_type
from .frames import FrameTree

KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""For topics whose last message is for those, too, who come later."""


@dataclass(frozen=True)
class MovingJoint:
    """A joint of a URDF that moves its link.

    Attributes:
        link: the link that it moves.
        origin: of the joint in its parent link's frame.
        axis: shape (3,), of unit length.
        slides: whether it is prismatic, not revolute.
    """

    name: str
    link: str
    origin: Pose
    axis: Array
    slides: bool

    def pose(self, q: float) -> Pose:
        """Return the pose of its link in the parent link, at a position [rad or m]."""
        if self.slides:
            return self.origin @ Pose(self.axis * q)
        x, y, z, w = Rotation.from_rotvec(self.axis * q).as_quat()
        return self.origin @ Pose((0.0, 0.0, 0.0), (w, x, y, z))


def moving_joints(urdf: str) -> Iterator[MovingJoint]:
    """Yield the revolute, continuous and prismatic joints of a URDF."""
    for joint in ET.fromstring(urdf).findall("joint"):
        parent, child, kind = joint.find("parent"), joint.find("child"), joint.get("type")
        if parent is None or child is None or kind not in ("revolute", "continuous", "prismatic"):
            continue
        given = {key: value for each in ("origin", "axis") for key, value in _attributes(joint, each).items()}
        xyz, rpy = ([float(v) for v in given.get(key, "0 0 0").split()] for key in ("origin.xyz", "origin.rpy"))
        axis = np.array([float(v) for v in given.get("axis.xyz", "1 0 0").split()])
        origin = Pose(xyz, quaternion_of(*rpy), parent.attrib["link"])
        axis = axis / np.linalg.norm(axis)
        yield MovingJoint(joint.attrib["name"], child.attrib["link"], origin, axis, kind == "prismatic")


def _attributes(joint: ET.Element, name: str) -> dict[str, str]:
    found = joint.find(name)
    return {} if found is None else {f"{name}.{key}": value for key, value in found.attrib.items()}


class RobotStatePublisher(Published):
    """Publishes `/robot_description`, `/tf` and `/tf_static`, as robot_state_publisher does.

    Args:
        executors: which measure all joints; others are where the description has them at rest.
        fixed: frames that don't move -> their pose in their parent, such as those of cameras.
        rate: of `/tf` [Hz].
        now: the time of its stamps [s].
    """

    def __init__(
        self,
        bus: Bus,
        description: RobotDescription,
        executors: Sequence[Executor],
        fixed: Mapping[str, Pose],
        rate: float = 30.0,
        now: Callable[[], float] = time.time,
    ):
        ensure_package("tf2_msgs")
        self._bus, self._executors, self._period, self._now = bus, executors, 1 / rate, now
        self._joints, self._mimics = list(moving_joints(description.urdf)), description.mimics
        self._rest = description.at_rest
        self._type, text = load_type("tf2_msgs/msg/TFMessage"), load_type("std_msgs/msg/String")
        frames = FrameTree.of_urdf(description.urdf).with_poses(fixed).poses
        node = bus.node

        def begin() -> None:
            self._moving = node.create_publisher(self._type, "/tf", 10)
            self._kept = [
                node.create_publisher(text, "/robot_description", KEPT),
                node.create_publisher(self._type, "/tf_static", KEPT),
            ]
            self._kept[0].publish(text(data=description.urdf))
            self._kept[1].publish(self._message(frames))

        bus.ask(begin)
        super().__init__("grip_robot_state")

    def _publish(self) -> None:
        while not self._closed.wait(self._period):
            try:
                positions = dict(self._rest)
                for executor in self._executors:
                    positions |= executor.state().as_mapping()
            except GripError:
                return  # what measures has ended; whoever runs it says so
            for name, mimic in self._mimics.items():
                positions[name] = mimic.multiplier * positions.get(mimic.joint, 0.0) + mimic.offset
            poses = {joint.link: joint.pose(positions.get(joint.name, 0.0)) for joint in self._joints}
            message = self._message(poses)
            self._bus.post(partial(self._moving.publish, message))

    def _message(self, poses: Mapping[str, Pose]) -> Message:
        transforms, stamp = [], header("", self._now()).stamp
        for child, pose in poses.items():
            transform = pose_to_transform_stamped(pose)
            transform.child_frame_id, transform.header.stamp = child, stamp
            transforms.append(transform)
        return self._type(transforms=transforms)


class ClockPublisher(Published):
    """Publishes `/clock`.

    Args:
        now: the simulated time [s].
        rate: [Hz].
    """

    def __init__(self, bus: Bus, now: Callable[[], float], rate: float = 100.0):
        self._writer, self._now, self._period = bus.writer("rosgraph_msgs/msg/Clock", "/clock"), now, 1 / rate
        super().__init__("grip_clock")

    def _publish(self) -> None:
        while not self._closed.wait(self._period):
            self._writer.publish(self._writer.type(clock=header("", self._now()).stamp))
