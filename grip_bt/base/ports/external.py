"""Other people's software and stores: components, ROS itself, named values that outlive a task."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from grip_bt.base.operation import Operation
from grip_bt.base.values import Pose


@runtime_checkable
class Component(Protocol):
    """An external component: somebody's service or action, reached by its contract."""

    def call(self, request: Mapping[str, object]) -> Operation[Mapping[str, object]]:
        """Send the request's fields; the result holds the response's fields, converted to GRIP's values.

        Ends with ServerLostError, ServerTimeOutError or BadReplyError.
        """


@runtime_checkable
class Ros(Protocol):
    """What leaves ask of ROS directly: topics, frames and parameters, by name; message types as ROS spells them."""

    def check(self, name: str, message: str = "") -> None:
        """Check a name of the graph, and a message type that is going to be used, before anything moves.

        Raises:
            GripError: it can't be one; there is no such message, or its package isn't available.
        """

    def listen(self, topic: str, message: str) -> None:
        """Subscribe now, so that a later `recent` finds what came since."""

    def next(self, topic: str, message: str, value: str, timeout: float) -> Operation[object]:
        """Wait for the next message and return it as the declared type `value`. Ends with ServerTimeOutError.

        Args:
            topic: its full name.
            message: its ROS type; empty for what it is published as.
            value: what becomes of it; `Any` leaves it as it is.
            timeout: how long to wait [s]; infinite for as long as it takes.
        """

    def recent(self, topic: str, message: str, value: str, max_age: float, timeout: float) -> Operation[object]:
        """Return the last message when it is at most `max_age` [s] old, else the next."""

    def together(self, topics: Mapping[str, str], slop: float, timeout: float) -> Operation[Mapping[str, Any]]:
        """Wait for a message of each topic (topic -> type), stamped at most `slop` [s] apart; by topic."""

    def publish(self, topic: str, message: str, value: object, subscribers: int, timeout: float) -> Operation[None]:
        """Publish a value when at least `subscribers` listen."""

    def transform(self, target: str, source: str, timeout: float, at: float | None = None) -> Operation[Pose]:
        """Return the pose of frame `source` in frame `target`, as it is or as it was at a time [s].

        Ends with an error of code `no_frame`.
        """

    def get_parameter(self, node: str, name: str, timeout: float) -> Operation[object]:
        """Return a parameter of a node. Ends with ServerLostError, or BadReplyError when it isn't set."""

    def set_parameter(self, node: str, name: str, value: object, timeout: float) -> Operation[None]:
        """Set a parameter of a node. Ends with ServerLostError, or BadReplyError with the node's reason."""


@runtime_checkable
class Messages(Protocol):
    """Named values that outlive a task: stores of joint states, poses, grasps, anything."""

    def put(self, store: str, name: str, value: object, provenance: str = "") -> Operation[None]:
        """Add or replace a value; without a name it goes to the end of the store's queue.

        Raises:
            WrongTypeError: the store holds another type.
        """

    def get(self, store: str, name: str) -> Operation[Any]:
        """Return an entry, with `value`, `time` [s of the Unix epoch] and `provenance`.

        Without a name: the oldest of the store's queue, which is removed. Ends with NoEntryError or EmptyQueueError.
        """

    def names(self, store: str) -> Operation[tuple[str, ...]]:
        """Return the names in a store. Ends with NoEntryError."""

    def delete(self, store: str, name: str) -> Operation[None]:
        """Remove an entry. Ends with NoEntryError."""

    def reset(self, store: str = "") -> Operation[None]:
        """Empty a store, or all, and read the project's files again. Ends with NoEntryError."""

    def save(self) -> Operation[int]:
        """Keep everything for later runs; the result is the number of entries."""
