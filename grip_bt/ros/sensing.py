"""The sensors of a project that speak on topics; each stands alone, and one that is broken says so when it is asked."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from grip_bt.base.errors import GripError
from grip_bt.base.failures import BadReplyError, CanceledError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.values import CameraInfo, RgbdFrame
from grip_bt.task.catalog.ros_config import CameraTopics, SensorConfig

from .client.types import ConversionError, Message
from .command import start_process
from .convert import from_message
from .convert_values import camera_from_message, depth_from_message, image_from_message, seconds
from .frames import ROOT, FrameError, frame_of, mounted_frames, transformed
from .interface import RosInterface
from .process import Process, stop_all

T = TypeVar("T")
FRAME_WAIT = 0.5
"""How long the transforms of a message's time may come after it [s]."""


def taken(
    ros: RosInterface,
    topics: Mapping[str, str],
    slop: float,
    timeout: float,
    made: Callable[[Mapping[str, Message]], Steps[T]],
) -> Steps[T]:
    """Take messages together until something can be made of them, at most for a time.

    Args:
        topics: topic -> its message's type.
        slop: how far their stamps may be apart [s].
        timeout: in all [s].
        made: makes it; with FrameError messages that come later are tried, since TF may be heard of only since then.
    """
    left, deadline = timeout, time.monotonic() + timeout
    while True:
        messages = yield ros.together(topics, slop, left)
        try:
            return (yield from made(messages))
        except FrameError:
            left = deadline - time.monotonic()
            if left < FRAME_WAIT:
                raise


class TopicSensor:
    """A sensor on topics; implements `grip_bt.base.ports.Sensor`; `process`: its driver, where we started it."""

    def __init__(self, name: str, config: SensorConfig, ros: RosInterface, process: Process | None = None):
        self.name, self.config, self.process = name, config, process
        self._ros = ros
        self._messages = {topic.topic: topic.message_type() for topic in config.topics.values()}
        self._captures: set[Operation[Mapping[str, object]]] = set()
        for topic, message in self._messages.items():
            ros.listen(topic, message)
        if config.given_in is not None:
            ros.transforms.listen()
        if process is not None:
            process.when_ended(self._driver_ended)

    def capture(self) -> Operation[Mapping[str, object]]:
        """Take one value of each output, from one moment that lies after this call.

        Ends with ServerTimeOutError after the sensor's time, SensorError when its driver dies or what it sent can't be
        used, FrameError when a value can't be brought into the frame that is asked for.
        """
        capture = run_steps(self._captured())
        self._captures.add(capture)
        capture.add_done_callback(lambda: self._captures.discard(capture))
        if self.process is not None and not self.process.alive:
            self._driver_ended()
        return capture

    def _driver_ended(self) -> None:
        for capture in list(self._captures):
            capture.cancel()

    def _captured(self) -> Steps[Mapping[str, object]]:
        config = self.config
        try:
            return (yield from taken(self._ros, self._messages, config.slop, config.timeout, self._values))
        except CanceledError:
            if self.process is None or self.process.alive:
                raise
            raise SensorError(f"sensor {self.name}: {self.process.describe_end()}") from None

    def _values(self, messages: Mapping[str, Message]) -> Steps[Mapping[str, object]]:
        found = {}
        infos = [t.topic for t in self.config.topics.values() if t.type == "CameraInfo"]
        info = from_message(messages[infos[0]], "CameraInfo") if infos else None
        for port, topic in self.config.topics.items():
            try:
                value = _value(messages[topic.topic], topic.type, info)
            except (ConversionError, BadReplyError) as error:
                raise SensorError(f"sensor {self.name}: {topic.topic}: {error}") from None
            found[port] = yield from self._placed(value, messages[topic.topic])
        return found

    def _placed(self, value: object, message: Message) -> Steps[object]:
        """Bring a value into the frame that is asked for, from where its own was when the message was stamped."""
        wanted, present = self.config.given_in, frame_of(value)
        if wanted is None or present in (None, wanted):
            return value
        stamp = seconds(message.header.stamp) if hasattr(message, "header") else 0.0
        pose = yield self._ros.transforms.lookup(wanted, str(present), FRAME_WAIT, stamp or None)
        try:
            return transformed(value, pose)
        except TypeError:
            return value  # an image has a frame, but no points in it


class UnavailableSensor:
    """A sensor or a camera that couldn't be set up; others go on without it. Implements `ports.Sensor` and `Camera`.

    Args:
        what: such as `sensor left`.
    """

    process: Process | None = None

    def __init__(self, what: str, reason: str):
        self.what, self.reason = what, reason

    def info(self) -> NoReturn:
        """Raise SensorError, which says what is wrong."""
        raise SensorError(f"{self.what}: {self.reason}")

    def capture(self) -> Operation[Any]:
        return Operation.failed(SensorError(f"{self.what}: {self.reason}"))


def unnamed_camera(name: str) -> UnavailableSensor:
    """Return a camera whose topics nobody has named; it says what to write."""
    topics = "{image: /camera/color/image_raw, depth: /camera/depth/image_raw, info: /camera/color/camera_info}"
    advice = f"add to grip.yaml: `ros: {{cameras: {{{name}: {topics}}}}}`"
    return UnavailableSensor(f"camera {name}", f"its topics are not configured; {advice}")


def open_sensors(
    sensors: Mapping[str, SensorConfig], ros: RosInterface, project: Path, domain_id: int | None = None
) -> dict[str, TopicSensor | UnavailableSensor]:
    """Start the drivers of sensors and listen to their topics; what is wrong with one is said when it is asked.

    Args:
        project: the project's folder, in which drivers are started; they log into `.grip/logs/sensor-<name>.log`.
        domain_id: the DDS domain of the drivers.
    """
    _, broken = mounted_frames(sensors)
    opened: dict[str, TopicSensor | UnavailableSensor] = {}
    for name, config in sensors.items():
        if name in broken:
            opened[name] = UnavailableSensor(f"sensor {name}", broken[name])
            continue
        try:
            log = project / ".grip" / "logs" / f"sensor-{name}.log"
            driver = start_process(f"sensor {name}", config.driver, project, log, domain_id)
            opened[name] = TopicSensor(name, config, ros, driver)
        except (GripError, OSError) as error:
            opened[name] = UnavailableSensor(f"sensor {name}", str(error))
    return opened


def close_sensors(sensors: Mapping[str, TopicSensor | UnavailableSensor]) -> None:
    """End all drivers, together."""
    stop_all([s.process for s in sensors.values() if s.process is not None])


def _value(message: Message, type_: str, info: CameraInfo | None) -> object:
    if type_ == "DepthImage":
        if info is None:
            raise ConversionError("", "a DepthImage needs the camera's geometry: add a topic of type CameraInfo")
        return depth_from_message(message, info)
    return from_message(message, type_)


class RosCamera:
    """Implements `grip_bt.base.ports.Camera` over topics.

    Args:
        ros: the connection to ROS, which knows where the camera's frame is.
    """

    def __init__(self, name: str, config: CameraTopics, ros: RosInterface):
        self._name, self._config, self._ros = name, config, ros
        self._topics = {
            config.image: "sensor_msgs/msg/Image",
            config.depth: "sensor_msgs/msg/Image",
            config.info: "sensor_msgs/msg/CameraInfo",
        }
        self._info: CameraInfo | None = None
        for topic, type_ in self._topics.items():
            ros.listen(topic, type_)
        if config.mount is None:
            ros.transforms.listen()

    def info(self) -> CameraInfo:
        """Return the camera's geometry, as of the last frame. Raises SensorError: none was taken yet."""
        if self._info is None:
            raise SensorError(f"camera {self._name}: nothing was heard on {self._config.info} yet")
        return self._info

    def capture(self) -> Operation[RgbdFrame]:
        """Take one frame that lies after this call.

        Ends with ServerTimeOutError after the camera's time, FrameError when nobody says where it is, SensorError when
        what it sent can't be used.
        """
        return run_steps(taken(self._ros, self._topics, self._config.slop, self._config.timeout, self._frame))

    def _frame(self, messages: Mapping[str, Message]) -> Steps[RgbdFrame]:
        depth, given = messages[self._config.depth], messages[self._config.info]
        frame = self._config.mount.frame if self._config.mount is not None else given.header.frame_id
        pose = yield self._ros.transforms.lookup(ROOT, frame, FRAME_WAIT, seconds(depth.header.stamp) or None)
        try:
            info = replace(camera_from_message(given), pose=pose)
            image = image_from_message(messages[self._config.image])
            made = RgbdFrame(image, depth_from_message(depth, info))
        except (ConversionError, BadReplyError, ValueError) as error:
            raise SensorError(f"camera {self._name}: {error}") from None
        if image.pixels.shape[:2] != made.depth.depth.shape:
            sizes = " and ".join(f"{a.shape[1]} x {a.shape[0]}" for a in (image.pixels, made.depth.depth))
            reason = f"colour and depth have {sizes} pixels; use the depth topic that is registered to the colour image"
            raise SensorError(f"camera {self._name}: {reason}")
        self._info = info
        return made
