"""A camera of ours as the topics of an RGB-D driver: colour, depth in its view, geometry, points."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

from grip_bt.base.errors import GripError
from grip_bt.base.ports import Camera
from grip_bt.base.values import DepthImage, Image, Pose, RgbdFrame

from ..bus import Bus
from ..convert_perception import camera_to_message, cloud_to_message, depth_to_message, image_to_message

TOPICS = {
    "image": ("color/image_raw", "sensor_msgs/msg/Image"),
    "depth": ("depth/image_raw", "sensor_msgs/msg/Image"),
    "info": ("color/camera_info", "sensor_msgs/msg/CameraInfo"),
    "points": ("points", "sensor_msgs/msg/PointCloud2"),
}

SHARE = 0.4
"""What takes the frames may spend no more than this share of its time on them: it moves the robot too."""


class ServedCamera:
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
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._publish, name=f"grip_camera_{name}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Publish no more."""
        self._closed.set()
        self._thread.join(2.0)

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
