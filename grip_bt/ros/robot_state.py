"""What a robot's driver says of itself beside its joints: its description, where its links are, and the time."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from rclpy.qos import DurabilityPolicy, QoSProfile

from grip_bt.base.errors import GripError
from grip_bt.base.ports import Executor
from grip_bt.base.values import Pose
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.description.tree import MOVABLE
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.convert_geometry import header, pose_to_transform_stamped
from grip_bt.ros.interfaces.build import ensure_package
from grip_bt.ros.served import Published

from .client.types import Message, load_type
from .frames import FrameTree, joints_of

KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""For topics whose last message is for those, too, who come later."""


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
        self._joints = [joint for joint in joints_of(description.urdf) if joint.type in MOVABLE]
        self._mimics = description.mimics
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
