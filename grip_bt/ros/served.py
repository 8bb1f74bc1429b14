"""What we serve to others of a robot: measured joints, frames, a camera and the time, on topics."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from rclpy.qos import DurabilityPolicy, QoSProfile

from grip_bt.base.arrays import Array
from grip_bt.base.errors import GripError
from grip_bt.base.ports import Camera, Executor, HandPort
from grip_bt.base.values import DepthImage, Image, Pose, RgbdFrame
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.description.tree import Tree
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.convert_values import (
    camera_to_message,
    cloud_to_message,
    depth_to_message,
    header,
    image_to_message,
    pose_to_transform_stamped,
)
from grip_bt.ros.interfaces.build import ensure_package

from .client.topic import TopicWriter
from .client.types import InterfaceType, Message, load_type
from .frames import FrameTree

Measured = Executor | HandPort
Writers = Mapping[str, TopicWriter]
RATE = 50.0
"""Messages of joint states a second."""
UNHEARD = 0.2
"""Interval at which it is asked whether somebody listens now [s]."""


class Published:
    """What is published again and again while somebody listens, on a thread of its own, until it is closed.

    Args:
        period: [s].
        writers: key -> what publishes on a topic.
        once: publishes what there is now, given the keys of topics with listeners; called once a period, or as often
            as it can be.
    """

    def __init__(self, bus: Bus, name: str, period: float, writers: Writers, once: Callable[[list[str]], object]):
        self._closed, self._bus, self._period, self._writers, self._once = threading.Event(), bus, period, writers, once
        for writer in writers.values():
            writer.advertise()
        self._thread = threading.Thread(target=self._publish, name=name, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._closed.set()
        self._thread.join(2.0)

    def _publish(self) -> None:
        due = time.monotonic()
        while not self._closed.wait(max(0.0, due - time.monotonic())):
            due = max(due + self._period, time.monotonic())
            try:
                if wanted := self._bus.ask(lambda: [key for key, each in self._writers.items() if each.listeners()]):
                    self._once(wanted)
                else:
                    due = time.monotonic() + UNHEARD
            except GripError:
                return  # what measures has ended; whoever runs it says so


def publish_joints(bus: Bus, topic: str, executors: Sequence[Measured], now: Callable[[], float]) -> Published:
    """Publish where joints are, in one message, on a topic such as `/joint_states`; `now` is the time of stamps [s]."""
    writer = bus.writer("sensor_msgs/msg/JointState", topic)

    def once(_: list[str]) -> None:
        stamp, states = now(), [executor.state() for executor in executors]
        message = writer.type(header=header("", stamp))
        message.name = [name for state in states for name in state.names]
        message.position = [float(value) for state in states for value in state.position]
        for part in ("velocity", "effort"):
            known = [getattr(state, part) for state in states]
            if all(values is not None for values in known):
                setattr(message, part, [float(value) for values in known for value in values])
        writer.publish(message)

    return Published(bus, "grip_joint_states", 1 / RATE, {topic: writer}, once)


def publish_felt(
    bus: Bus,
    topics: Mapping[str, str],
    now: Callable[[], float],
    measure: Callable[[], Mapping[str, Any]],
    type_: InterfaceType,
    message_of: Callable[[str, Any, float], Message],
) -> Published:
    """Publish what links of a robot feel, each on its topic.

    Args:
        topics: link -> topic.
        now: the time of stamps [s].
        measure: returns link -> what is felt; 0 for those that it doesn't name.
        message_of: makes the message, of this type, of a link at a time [s].
    """
    writers = {link: bus.writer(type_, topic) for link, topic in topics.items()}

    def once(wanted: list[str]) -> None:
        felt, stamp = measure(), now()
        for link in wanted:
            writers[link].publish(message_of(link, felt.get(link, 0.0), stamp))

    return Published(bus, "grip_touch", 1 / RATE, writers, once)


def wrench_to_message(link: str, borne: Array, time: float) -> WrenchStamped:
    """Return force [N] and torque [N m] in a link's frame, shape (6,), at a time [s]."""
    x, y, z, *torque = borne.tolist()
    wrench = Wrench(force=Vector3(x=x, y=y, z=z), torque=Vector3(**dict(zip("xyz", torque, strict=True))))
    return WrenchStamped(header=header(link, time), wrench=wrench)


TOPICS: Mapping[str, tuple[str, str, Callable[[RgbdFrame], Message]]] = {
    "image": ("color/image_raw", "sensor_msgs/msg/Image", lambda taken: image_to_message(taken.image)),
    "depth": ("depth/image_raw", "sensor_msgs/msg/Image", lambda taken: depth_to_message(taken.depth)),
    "info": ("color/camera_info", "sensor_msgs/msg/CameraInfo", lambda taken: camera_to_message(taken.depth.info)),
    "points": ("points", "sensor_msgs/msg/PointCloud2", lambda taken: cloud_to_message(taken.cloud())),
}
"""Part of a frame -> its topic, the topic's type, and what makes its message."""

SHARE = 0.4
"""What takes the frames may spend no more than this share of its time on them: it moves the robot too."""


class CameraPublisher(Published):
    """Takes frames and publishes them, all messages of a frame with one stamp.

    Everything is in the optical frame `<name>_optical`; where that is, is for TF or the listener's own settings.

    Args:
        name: its topics are `/<name>/color/image_raw` and so on.
        rate: frames a second, at most.
        now: the time of its stamps [s].
    """

    def __init__(self, bus: Bus, name: str, camera: Camera, rate: float = 5.0, now: Callable[[], float] = time.time):
        self._camera, self._now, self.frame = camera, now, f"{name}_optical"
        self.topics = {part: f"/{name}/{topic}" for part, (topic, *_) in TOPICS.items()}
        writers = {part: bus.writer(TOPICS[part][1], topic) for part, topic in self.topics.items()}
        super().__init__(bus, f"grip_camera_{name}", 1 / rate, writers, self._take)

    def _take(self, wanted: list[str]) -> None:
        began, stamp = time.monotonic(), self._now()
        taken = self._camera.capture()
        taken.wait()
        self._send(taken.result(), stamp, wanted)
        took = time.monotonic() - began
        self._closed.wait(took / SHARE - took)

    def _send(self, taken: RgbdFrame, stamp: float, wanted: list[str]) -> None:
        info = replace(taken.depth.info, pose=Pose(frame=self.frame))
        here = RgbdFrame(Image(taken.image.pixels, self.frame, stamp), DepthImage(taken.depth.depth, info, stamp))
        for part in wanted:
            message = TOPICS[part][2](here)
            message.header.stamp.sec, message.header.stamp.nanosec = int(stamp), int(stamp % 1 * 1e9)
            message.header.frame_id = self.frame
            self._writers[part].publish(message)


KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""For topics whose last message is for those, too, who come later."""


def publish_frames(
    bus: Bus,
    robot: RobotDescription,
    executors: Sequence[Measured],
    fixed: Mapping[str, Pose],
    now: Callable[[], float],
    rate: float = 30.0,
) -> Published:
    """Publish `/robot_description`, `/tf` and `/tf_static`, as robot_state_publisher does.

    Args:
        executors: which measure all joints; others are where the description has them at rest.
        fixed: frames that don't move -> their pose in their parent, such as those of cameras.
        now: the time of stamps [s].
        rate: of `/tf` [Hz].
    """
    ensure_package("tf2_msgs")
    joints = [joint for joint in Tree.of(robot.urdf).joints.values() if joint.movable]
    frames, text = load_type("tf2_msgs/msg/TFMessage"), load_type("std_msgs/msg/String")

    def message(poses: Mapping[str, Pose]) -> Message:
        transforms, stamp = [], header("", now()).stamp
        for child, pose in poses.items():
            transform = pose_to_transform_stamped(pose)
            transform.child_frame_id, transform.header.stamp = child, stamp
            transforms.append(transform)
        return frames(transforms=transforms)

    def begin() -> None:
        kept = {"/robot_description": text(data=robot.urdf)}
        kept["/tf_static"] = message(FrameTree.of_urdf(robot.urdf).with_poses(fixed).poses)
        for topic, told in kept.items():
            bus.node.create_publisher(type(told), topic, KEPT).publish(told)

    bus.ask(begin)
    moving = bus.writer(frames, "/tf")

    def once(_: list[str]) -> None:
        positions = dict(robot.at_rest)
        for executor in executors:
            positions |= executor.state().as_mapping()
        there = robot.with_followers(positions)
        moving.publish(message({joint.child: joint.pose(there.get(joint.name, 0.0)) for joint in joints}))

    return Published(bus, "grip_robot_state", 1 / rate, {"/tf": moving}, once)


def publish_clock(bus: Bus, now: Callable[[], float], rate: float = 100.0) -> Published:
    """Publish the simulated time `now` [s] on `/clock`, at a rate [Hz]."""
    writer = bus.writer("rosgraph_msgs/msg/Clock", "/clock")

    def once(_: list[str]) -> None:
        writer.publish(writer.type(clock=header("", now()).stamp))

    return Published(bus, "grip_clock", 1 / rate, {"/clock": writer}, once)
