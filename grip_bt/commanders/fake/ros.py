"""A fake of ROS itself: topics that carry what was published, frames that are known, parameters that were set."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from grip_bt.base.failures import ExpectedError
from grip_bt.base.operation import Operation
from grip_bt.base.values import Pose


class FakeRos:
    """Implements `ports.Ros`.

    A topic gives what was last published on it, and something of its type before that. Nothing takes time.

    Args:
        make: returns a value of a type, by the type's name.
        frame: returns the pose of a frame (its second argument) in another; raises an ExpectedError where it can't.
    """

    def __init__(self, make: Callable[[str], Any], frame: Callable[[str, str], Pose]):
        self._make, self._frame = make, frame
        self._published: dict[str, Any] = {}
        self._parameters: dict[tuple[str, str], Any] = {}

    def check(self, name: str, message: str = "") -> None:
        """Take any name: a task is tried before its interfaces are built."""

    def listen(self, topic: str, message: str) -> None:
        """Nothing needs to be listened to."""

    def next(self, topic: str, message: str, value: str, timeout: float) -> Operation[Any]:
        """Return what the topic gives, as the type `value`, or as the message itself for `Any`."""
        if topic in self._published:
            return Operation.finished(self._published[topic])
        if not message and value == "Any":
            return Operation.finished(None)  # nobody has said what it carries
        return _tried(lambda: self._make(message if value == "Any" else value))

    def recent(self, topic: str, message: str, value: str, max_age: float, timeout: float) -> Operation[Any]:
        """Return what the topic gives; see `next`."""
        return self.next(topic, message, value, timeout)

    def together(self, topics: Mapping[str, str], slop: float, timeout: float) -> Operation[Mapping[str, Any]]:
        """Return what each topic gives, as messages."""
        return _tried(
            lambda: {t: self._published[t] if t in self._published else self._make(m) for t, m in topics.items()}
        )

    def publish(self, topic: str, message: str, value: Any, subscribers: int, timeout: float) -> Operation[None]:
        """Have the topic give `value` from now on, whoever would listen."""
        self._published[topic] = value
        return Operation.finished(None)

    def transform(self, target: str, source: str, timeout: float, at: float | None = None) -> Operation[Pose]:
        """Return where a frame is; it doesn't move."""
        return _tried(lambda: self._frame(target, source))

    def get_parameter(self, node: str, name: str, timeout: float) -> Operation[Any]:
        """Return what was set, and 0 before that."""
        return Operation.finished(self._parameters.get((node, name), 0))

    def set_parameter(self, node: str, name: str, value: Any, timeout: float) -> Operation[None]:
        """Keep a parameter."""
        self._parameters[node, name] = value
        return Operation.finished(None)


def _tried(make: Callable[[], Any]) -> Operation[Any]:
    try:
        return Operation.finished(make())
    except ExpectedError as error:
        return Operation.failed(error)
