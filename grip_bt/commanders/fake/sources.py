"""Fakes of what is seen and of other people's software: cameras, sensors, components, ROS."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import cycle
from typing import TypeVar

from grip_bt.base.failures import ExpectedError, SensorError, ServerLostError
from grip_bt.base.operation import Operation
from grip_bt.base.values import CameraInfo, Pose, RgbdFrame

T = TypeVar("T")


class FakeSensor:
    """Implements `ports.Sensor`.

    Args:
        moments: what captures give, one after the other, again and again: the value of each output by its name; an
            error stands for a failed capture.
    """

    def __init__(self, moments: Iterable[Mapping[str, object] | ExpectedError] = ()):
        self._moments = cycle(tuple(moments))

    def capture(self) -> Operation[Mapping[str, object]]:
        return _given(next(self._moments, SensorError("the fake sensor has nothing to give")))


class FakeCamera:
    """Implements `ports.Camera`.

    Args:
        info: the camera's geometry.
        frames: what the captures give, one after the other, again and again; an error stands for a failed capture.
    """

    def __init__(self, info: CameraInfo, frames: Iterable[RgbdFrame | ExpectedError] = ()):
        self._info, self._frames = info, cycle(tuple(frames))

    def info(self) -> CameraInfo:
        return self._info

    def capture(self) -> Operation[RgbdFrame]:
        return _given(next(self._frames, SensorError("the fake camera has no frames")))


def _given(value: T | ExpectedError) -> Operation[T]:
    return Operation.failed(value) if isinstance(value, ExpectedError) else Operation.finished(value)


Reply = Mapping[str, object] | ExpectedError | Callable[[Mapping[str, object]], Mapping[str, object]]


class FakeComponent:
    """Implements `ports.Component`.

    Args:
        replies: one after the other, again and again: fields of the response, a function of the request that returns
            them, or an error.

    Attributes:
        requests: what it was asked.
        given: how many replies it has given.
    """

    def __init__(self, replies: Iterable[Reply] = ()):
        self._replies = cycle(tuple(replies))
        self.requests: list[Mapping[str, object]] = []
        self.given = 0

    def put_back(self, given: int) -> None:
        """Go on with the reply that comes after so many.

        Args:
            given: how many it had given.
        """
        for _ in range(given - self.given):
            next(self._replies, None)
        self.given = max(given, self.given)

    def call(self, request: Mapping[str, object]) -> Operation[Mapping[str, object]]:
        self.requests.append(dict(request))
        self.given += 1
        reply = next(self._replies, ServerLostError("the fake component has no replies"))
        return _given(reply(request) if callable(reply) else reply)


class FakeRos:
    """Implements `ports.Ros`.

    A topic gives what was last published on it, and something of its type before that. Nothing takes time.

    Args:
        make: returns a value of a type, by the type's name.
        frame: returns the pose of a frame (its second argument) in another; raises an ExpectedError where it can't.
    """

    def __init__(self, make: Callable[[str], object], frame: Callable[[str, str], Pose]):
        self._make, self._frame = make, frame
        self._published: dict[str, object] = {}
        self._parameters: dict[tuple[str, str], object] = {}

    def check(self, name: str, message: str = "") -> None:
        """Take any name: a task is tried before its interfaces are built."""

    def listen(self, topic: str, message: str) -> None:
        """Nothing needs to be listened to."""

    def next(self, topic: str, message: str, value: str, timeout: float) -> Operation[object]:
        """Return what the topic gives, as the type `value`, or as the message itself for `Any`."""
        if topic in self._published:
            return Operation.finished(self._published[topic])
        if not message and value == "Any":
            return Operation.finished(None)  # nobody has said what it carries
        return _tried(lambda: self._make(message if value == "Any" else value))

    def recent(self, topic: str, message: str, value: str, max_age: float, timeout: float) -> Operation[object]:
        return self.next(topic, message, value, timeout)

    def together(self, topics: Mapping[str, str], slop: float, timeout: float) -> Operation[Mapping[str, object]]:
        return _tried(
            lambda: {t: self._published[t] if t in self._published else self._make(m) for t, m in topics.items()}
        )

    def publish(self, topic: str, message: str, value: object, subscribers: int, timeout: float) -> Operation[None]:
        self._published[topic] = value
        return Operation.finished(None)

    def transform(self, target: str, source: str, timeout: float, at: float | None = None) -> Operation[Pose]:
        return _tried(lambda: self._frame(target, source))

    def get_parameter(self, node: str, name: str, timeout: float) -> Operation[object]:
        return Operation.finished(self._parameters.get((node, name), 0))

    def set_parameter(self, node: str, name: str, value: object, timeout: float) -> Operation[None]:
        self._parameters[node, name] = value
        return Operation.finished(None)


def _tried(make: Callable[[], T]) -> Operation[T]:
    try:
        return Operation.finished(make())
    except ExpectedError as error:
        return Operation.failed(error)
