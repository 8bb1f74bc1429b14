"""Publishes a cloud, an image and a text until it is ended: `python ros_world.py`."""

from __future__ import annotations

import signal
import time

import numpy as np

from grip_bt.base.values import Image, PointCloud
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.client.types import load_type
from grip_bt.ros.convert import to_message

PERIOD = 0.1


def main() -> None:
    """Publish."""
    signal.signal(signal.SIGTERM, lambda *_: exit(0))
    cloud = PointCloud(np.random.default_rng(1).random((50, 3), dtype=np.float32), frame="camera")
    image = Image(np.full((6, 8, 3), 120, np.uint8), frame="camera")
    with Bus("world") as bus:
        told = [
            (bus.writer(type_, topic), to_message(value, load_type(type_)))
            for topic, type_, value in (
                ("/camera/points", "sensor_msgs/msg/PointCloud2", cloud),
                ("/camera/color", "sensor_msgs/msg/Image", image),
                ("/words", "std_msgs/msg/String", "hello"),
            )
        ]
        while True:
            for writer, message in told:
                writer.publish(message)
            time.sleep(PERIOD)


if __name__ == "__main__":
    main()
