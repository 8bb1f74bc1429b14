"""Frames that move, from the topics of TF, where its message package is there; frames that don't, from our own tree.

What is needed of TF is small: the transforms of the last seconds, and the way from one frame to another, now or at a
time. `tf2_ros` isn't on PyPI, so that is done here. `tf2_msgs` comes with a sourced ROS, or is built from a definition
of ours.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial

from grip_bt.base.errors import MissingPartError, UnknownNameError
from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation
from grip_bt.base.values import Pose

from .client.bus import Bus
from .client.topic import Received
from .client.types import load_type
from .convert_values import pose_from_stamped, seconds
from .frames import FrameError, FrameHistory, FrameTree

MESSAGE = "tf2_msgs/msg/TFMessage"
TOPICS = ("/tf", "/tf_static")
STALE = 10.0
"""A moving frame not heard of for this time is unknown [s]."""


class Transforms:
    """The frames of a run."""

    def __init__(self, bus: Bus, fixed: FrameTree | None = None):
        self._bus, self._fixed = bus, fixed or FrameTree()
        self._static: dict[str, Pose] = {}
        self._moving = FrameHistory()
        self._waiting: dict[Operation[Pose], Callable[[], Pose]] = {}
        self._lock = threading.RLock()
        self.listening = False

    def listen(self) -> bool:
        """Subscribe to TF; False where its messages aren't installed."""
        if not self.listening:
            try:
                type_ = load_type(MESSAGE)
            except (MissingPartError, UnknownNameError):
                return False
            self.listening = True
            for topic in TOPICS:
                fixed = topic.endswith("static")
                self._bus.reader(type_, topic).listen(partial(self._heard, fixed))
        return True

    def lookup(self, target: str, source: str, timeout: float, at: float | None = None) -> Operation[Pose]:
        """Return the pose of `source` in `target`: as it is now, or as it was.

        Args:
            timeout: how long to wait for the frames to be known [s].
            at: a time [s] of the stamps of TF, such as a picture's; between two transforms is interpolated. The last
                transforms that were heard when None.

        Ends with FrameError after `timeout`; at once when TF isn't listened to.
        """
        operation: Operation[Pose] = Operation()
        look = partial(self.known, target, source, at)
        heard = self.listen()
        with self._lock:
            self._waiting[operation] = look
        operation.add_done_callback(partial(self._forget, operation))
        self._try(operation, look, last=not heard)
        if not operation.done():
            timer = threading.Timer(timeout, self._try, (operation, look, True))
            timer.daemon = True
            timer.start()
            operation.add_done_callback(timer.cancel)
        return operation

    def _forget(self, operation: Operation[Pose]) -> None:
        with self._lock:
            self._waiting.pop(operation, None)

    def known(self, target: str, source: str, at: float | None = None) -> Pose:
        """Return the pose of `source` in `target` from what is known by now; see `lookup`.

        Raises:
            FrameError: it isn't known.
        """
        if at is None:
            return self.tree().lookup(target, source)
        with self._lock:
            tree = self._fixed.with_poses({**self._static, **self._moving.at(at)})
            spans = self._moving.spans()
        try:
            return tree.lookup(target, source)
        except FrameError as error:
            outside = [
                f"{child!r} is known from {begin:.3f} to {end:.3f} s, not at {at:.3f} s"
                for child, (begin, end) in sorted(spans.items())
                if not begin <= at <= end
            ]
            raise FrameError("; ".join([error.message, *outside]), **error.data) from None

    def tree(self) -> FrameTree:
        with self._lock:
            return self._fixed.with_poses({**self._static, **self._moving.latest(time.monotonic() - STALE)})

    def _heard(self, fixed: bool, received: Received) -> None:
        with self._lock:
            for transform in received.message.transforms:
                child, pose = transform.child_frame_id.lstrip("/"), pose_from_stamped(transform)
                if fixed:
                    self._static[child] = pose
                else:
                    self._moving.add(child, pose, seconds(transform.header.stamp), received.time)
            waiting = list(self._waiting.items())
        for operation, look in waiting:
            self._try(operation, look)

    def _try(self, operation: Operation[Pose], look: Callable[[], Pose], last: bool = False) -> None:
        try:
            operation.succeed(look())
        except FrameError as error:
            if not self.listening:
                reason = f"{error.message}; moving frames aren't heard, since tf2_msgs isn't installed"
                operation.fail(FrameError(reason, **error.data))
            elif last:
                closed = CanceledError("the connection to ROS was closed")
                operation.fail(closed if self._bus.closed else error)
