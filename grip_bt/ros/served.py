"""What we serve to others of a robot: measured joints, frames, a camera and the time, on topics."""

from __future__ import annotations

import threading
import time
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from rclpy.qos import DurabilityPolicy, QoSProfile

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

from .client.types import Message, load_type
from .frames import FrameTree

TYPE = "sensor_msgs/msg/JointState"
Measured = Executor | HandPort
RATE = 50.0
"""Messages of joint states a second."""


class Published:
    """What a thread of its own publishes until it is closed."""

    def __init__(self, name: str, period: float):
        self._closed, self._period = threading.Event(), period
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
                self._once()
            except GripError:
                return  # what measures has ended; whoever runs it says so

    @abstractmethod
    def _once(self) -> None:
        """Publish what there is now; called once a period, or as often as it can be."""


class JointStatePublisher(Published):
    """Publishes where joints are, in one message for all of them.

    Args:
        topic: such as `/joint_states`.
        now: the time of its stamps [s].
    """

    def __init__(self, bus: Bus, topic: str, executors: Sequence[Measured], now: Callable[[], float] = time.time):
        self._writer, self._executors, self._now = bus.writer(TYPE, topic), executors, now
        super().__init__("grip_joint_states", 1 / RATE)

    def _once(self) -> None:
        stamp, states = self._now(), [executor.state() for executor in self._executors]
        message = self._writer.type(header=header("", stamp))
        message.name = [name for state in states for name in state.names]
        message.position = [float(value) for state in states for value in state.position]
        for part in ("velocity", "effort"):
            known = [getattr(state, part) for state in states]
            if all(values is not None for values in known):
                setattr(message, part, [float(value) for values in known for value in values])
        self._writer.publish(message)


TOPICS = {
    "image": ("color/image_raw", "sensor_msgs/msg/Image"),
    "depth": ("depth/image_raw", "sensor_msgs/msg/Image"),
    "info": ("color/camera_info", "sensor_msgs/msg/CameraInfo"),
    "points": ("points", "sensor_msgs/msg/PointCloud2"),
}

SHARE = 0.4
"""What takes the frames may spend no more than this share of its time on them: it moves the robot too."""


class CameraPublisher(Published):
    """Takes frames while somebody listens, and publishes them, all messages of a frame with one stamp.

    Everything is in the optical frame `<name>_optical`; where that is, is for TF or the listener's own settings.

    Args:
        name: its topics are `/<name>/color/image_raw` and so on.
        rate: frames a second, at most.
        now: the time of its stamps [s].
    """

    def __init__(self, bus: Bus, name: str, camera: Camera, rate: float = 5.0, now: Callable[[], float] = time.time):
        self._camera, self._now, self.frame = camera, now, f"{name}_optical"
        self.topics = {part: f"/{name}/{topic}" for part, (topic, _) in TOPICS.items()}
        self._writers = {part: bus.writer(TOPICS[part][1], topic) for part, topic in self.topics.items()}
        for writer in self._writers.values():
            writer.advertise()
        super().__init__(f"grip_camera_{name}", 1 / rate)

    def _once(self) -> None:
        wanted = [part for part, writer in self._writers.items() if writer.listeners()]
        if wanted:
            began, stamp = time.monotonic(), self._now()
            taken = self._camera.capture()
            taken.wait()
            self._send(taken.result(), stamp, wanted)
            took = time.monotonic() - began
            self._closed.wait(took / SHARE - took)

    def _send(self, taken: RgbdFrame, stamp: float, wanted: list[str]) -> None:
        info = replace(taken.depth.info, pose=Pose(frame=self.frame))
        here = RgbdFrame(Image(taken.image.pixels, self.frame, stamp), DepthImage(taken.depth.depth, info, stamp))
        messages = {
            "image": lambda: image_to_message(here.image),
            "depth": lambda: depth_to_message(here.depth),
            "info": lambda: camera_to_message(info),
            "points": lambda: cloud_to_message(here.cloud()),
        }
        for part in wanted:
            message = messages[part]()
            message.header.stamp.sec, message.header.stamp.nanosec = int(stamp), int(stamp % 1 * 1e9)
            message.header.frame_id = self.frame
            self._writers[part].publish(message)


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
        executors: Sequence[Measured],
        fixed: Mapping[str, Pose],
        rate: float = 30.0,
        now: Callable[[], float] = time.time,
    ):
        ensure_package("tf2_msgs")
        self._bus, self._executors, self._now = bus, executors, now
        self._joints = [joint for joint in Tree.of(description.urdf).joints.values() if joint.movable]
        self._robot = description
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
        super().__init__("grip_robot_state", 1 / rate)

    def _once(self) -> None:
        positions = dict(self._robot.at_rest)
        for executor in self._executors:
            positions |= executor.state().as_mapping()
        there = self._robot.with_followers(positions)
        message = self._message({joint.child: joint.pose(there.get(joint.name, 0.0)) for joint in self._joints})
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
        self._writer, self._now = bus.writer("rosgraph_msgs/msg/Clock", "/clock"), now
        super().__init__("grip_clock", 1 / rate)

    def _once(self) -> None:
        self._writer.publish(self._writer.type(clock=header("", self._now()).stamp))
