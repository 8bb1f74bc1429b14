"""An RGB-D camera on topics: colour, depth in its view, and geometry, from one moment."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from grip_bt.base.failures import BadReplyError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.values import CameraInfo, RgbdFrame
from grip_bt.task.catalog.ros_config import CameraTopics

from .convert_geometry import seconds
from .convert_perception import camera_from_message, depth_from_message, image_from_message
from .fields import ConversionError
from .sensors import FRAME_WAIT, taken
from .steps import Steps, walk

if TYPE_CHECKING:
    from collections.abc import Mapping

    from .door import RosDoor

WORLD = "world"


class RosCamera:
    """Implements `grip_bt.base.ports.Camera` over topics.

    Args:
        name: the sensor's.
        config: its topics.
        door: the connection to ROS, which knows where the camera's frame is.
    """

    def __init__(self, name: str, config: CameraTopics, door: RosDoor):
        self._name, self._config, self._door = name, config, door
        self._topics = {
            config.image: "sensor_msgs/msg/Image",
            config.depth: "sensor_msgs/msg/Image",
            config.info: "sensor_msgs/msg/CameraInfo",
        }
        self._info: CameraInfo | None = None
        for topic, type_ in self._topics.items():
            door.listen(topic, type_)
        if config.mount is None:
            door.transforms.listen()

    def info(self) -> CameraInfo:
        """Return the camera's geometry, as of the last frame.

        Raises:
            SensorError: none was taken yet.
        """
        if self._info is None:
            raise SensorError(f"camera {self._name}: nothing was heard on {self._config.info} yet")
        return self._info

    def capture(self) -> Operation[RgbdFrame]:
        """Take one frame that lies after this call.

        Ends with ServerTimeOutError after the camera's time, FrameError when nobody says where it is, SensorError when
        what it sent can't be used.
        """
        return walk(taken(self._door, self._topics, self._config.slop, self._config.timeout, self._frame))

    def _frame(self, messages: Mapping[str, Any]) -> Steps[RgbdFrame]:
        depth, given = messages[self._config.depth], messages[self._config.info]
        frame = self._config.mount.frame if self._config.mount is not None else given.header.frame_id
        pose = yield self._door.transforms.lookup(WORLD, frame, FRAME_WAIT, seconds(depth.header.stamp) or None)
        try:
            info = replace(camera_from_message(given), pose=pose)
            image = image_from_message(messages[self._config.image])
            taken = RgbdFrame(image, depth_from_message(depth, info))
        except (ConversionError, BadReplyError, ValueError) as error:
            raise SensorError(f"camera {self._name}: {error}") from None
        if image.pixels.shape[:2] != taken.depth.depth.shape:
            sizes = " and ".join(f"{a.shape[1]} x {a.shape[0]}" for a in (image.pixels, taken.depth.depth))
            reason = f"colour and depth have {sizes} pixels; `depth` is the one that is aligned to the colour image"
            raise SensorError(f"camera {self._name}: {reason}")
        self._info = info
        return taken


class UnnamedCamera:
    """A sensor whose topics nobody has named; others go on without it. Implements `grip_bt.base.ports.Camera`."""

    def __init__(self, name: str):
        self._name = name

    def info(self) -> CameraInfo:
        """Raise SensorError, which says what to write."""
        raise self._error()

    def capture(self) -> Operation[RgbdFrame]:
        """End with SensorError, likewise."""
        return Operation.failed(self._error())

    def _error(self) -> SensorError:
        topics = "{image: /camera/color/image_raw, depth: /camera/depth/image_raw, info: /camera/color/camera_info}"
        return SensorError(
            f"camera {self._name}: its topics aren't named; in grip.yaml: "
            f"`ros: {{cameras: {{{self._name}: {topics}}}}}`"
        )
