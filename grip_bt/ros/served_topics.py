"""Measured joints, and a camera of ours, on topics: what drivers of a robot and of an RGB-D camera publish."""

from __future__ import annotations

import threading
import time
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace

from grip_bt.base.errors import GripError
from grip_bt.base.ports import Camera, Executor
from grip_bt.base.values import DepthImage, Image, Pose, RgbdFrame

from .client.bus import Bus
from .convert_geometry import header
from .convert_perception import camera_to_message, cloud_to_message, depth_to_message, image_to_message

TYPE = "sensor_msgs/msg/JointState"


class _Published:
    """What a thread of its own publishes until it is closed."""

    def __init__(self, name: str):
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._publish, name=name, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Publish no more."""
        self._closed.set()
        self._thread.join(2.0)

    @abstractmethod
    def _publish(self) -> None:
        """Publish until it is closed."""


class ServedJoints(_Published):
    """Publishes where joints are, stamped with the wall's time, in one message for all of them.

    Args:
        bus: the connection to ROS.
        topic: such as `/joint_states`.
        executors: which measure them.
        rate: messages a second.
    """

    def __init__(self, bus: Bus, topic: str, executors: Sequence[Executor], rate: float = 50.0):
        self._writer, self._executors, self._period = bus.writer(TYPE, topic), executors, 1 / rate
        super().__init__("grip_joint_states")

    def _publish(self) -> None:
        due = time.monotonic()
        while not self._closed.wait(max(0.0, due - time.monotonic())):
            due = max(due + self._period, time.monotonic())
            try:
                self._writer.publish(self._message())
            except GripError:
                return  # what measures has ended; whoever runs it says so

    def _message(self) -> object:
        stamp, states = time.time(), [executor.state() for executor in self._executors]
        message = self._writer.type(header=header("", stamp))
        message.name = [name for state in states for name in state.names]
        message.position = [float(value) for state in states for value in state.position]
        for field in ("velocity", "effort"):
            known = [getattr(state, field) for state in states]
            if all(values is not None for values in known):
                setattr(message, field, [float(value) for values in known for value in values])
        return message


TOPICS = {
    "image": ("color/image_raw", "sensor_msgs/msg/Image"),
    "depth": ("depth/image_raw", "sensor_msgs/msg/Image"),
    "info": ("color/camera_info", "sensor_msgs/msg/CameraInfo"),
    "points": ("points", "sensor_msgs/msg/PointCloud2"),
}

SHARE = 0.4
"""What takes the frames may spend no more than this share of its time on them: it moves the robot too."""


class ServedCamera(_Published):
    """Takes frames while somebody listens, and publishes them, all messages of a frame with one stamp.

    Everything is in the optical frame `<name>_optical`; where that is, is for TF or the listener's own settings.

    Args:
        bus: the connection to ROS.
        name: its topics are `/<name>/color/image_raw` and so on.
        camera: takes the frames.
        rate: frames a second, at most.
    """

    def __init__(self, bus: Bus, name: str, camera: Camera, rate: float = 5.0):
        self._camera, self._period, self.frame = camera, 1 / rate, f"{name}_optical"
        self.topics = {part: f"/{name}/{topic}" for part, (topic, _) in TOPICS.items()}
        self._writers = {part: bus.writer(TOPICS[part][1], topic) for part, topic in self.topics.items()}
        for writer in self._writers.values():
            writer.advertise()
        super().__init__(f"grip_camera_{name}")

    def _publish(self) -> None:
        pause = 0.0
        while not self._closed.wait(pause):
            pause, began = self._period, time.monotonic()
            wanted = [part for part, writer in self._writers.items() if writer.listeners()]
            if not wanted:
                continue
            try:
                stamp = time.time()
                taken = self._camera.capture()
                taken.wait()
                self._send(taken.result(), stamp, wanted)
            except GripError:
                return  # the camera has ended; whoever runs it says so
            took = time.monotonic() - began
            pause = max(self._period - took, took / SHARE - took)

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
