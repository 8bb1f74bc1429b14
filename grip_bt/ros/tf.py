"""Frames that move, from the topics of TF, where its message package is there; frames that don't, from our own tree.

`tf2_ros` isn't on PyPI. What is needed of it is small: the last transform of each frame, and the way from one to
another. `tf2_msgs` comes with a sourced ROS, or is built by `grip interfaces build`.
"""

from __future__ import annotations

import threading
import time
from typing import Any

from grip_bt.errors import MissingPartError, UnknownNameError
from grip_bt.operation import Operation
from grip_bt.values import Pose

from .bus import Bus
from .convert_geometry import pose_from_transform_stamped
from .frames import FrameError, FrameTree
from .types import load_type

MESSAGE = "tf2_msgs/msg/TFMessage"
TOPICS = ("/tf", "/tf_static")
STALE = 10.0
"""A moving frame that wasn't heard of for so long isn't known any more [s]."""


class Transforms:
    """The frames of a run.

    Args:
        bus: the connection to ROS.
        fixed: what never moves.
    """

    def __init__(self, bus: Bus, fixed: FrameTree | None = None):
        self._bus, self._fixed = bus, fixed or FrameTree()
        self._heard: dict[str, tuple[Pose, float]] = {}
        self._lock = threading.Lock()
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
                self._bus.reader(type_, topic).listen(lambda received, fixed=fixed: self._hear(received.message, fixed))
        return True

    def lookup(self, target: str, source: str, timeout: float) -> Operation[Pose]:
        """Return the pose of `source` in `target`, with the last transforms that were heard.

        Ends with FrameError after `timeout` [s]; at once when TF isn't listened to.
        """
        if not self.listening:
            self.listen()
        operation: Operation[Pose] = Operation()
        deadline = time.monotonic() + timeout
        self._try(operation, target, source, deadline)
        return operation

    def _try(self, operation: Operation[Pose], target: str, source: str, deadline: float) -> None:
        if operation.done():
            return
        try:
            operation.succeed(self.tree().lookup(target, source))
        except FrameError as error:
            if not self.listening:
                reason = f"{error.message}; moving frames aren't heard, since tf2_msgs isn't installed"
                operation.fail(FrameError(reason, **error.data))
            elif time.monotonic() > deadline or self._bus.closed:
                operation.fail(error)
            else:
                later = threading.Timer(0.02, self._try, (operation, target, source, deadline))
                later.daemon = True
                later.start()

    def tree(self) -> FrameTree:
        """Return all frames as they are now."""
        oldest = time.monotonic() - STALE
        with self._lock:
            heard = {child: pose for child, (pose, at) in self._heard.items() if at > oldest}
        return self._fixed.with_poses(heard)

    def _hear(self, message: Any, fixed: bool) -> None:
        at = float("inf") if fixed else time.monotonic()
        with self._lock:
            for transform in message.transforms:
                child = transform.child_frame_id.lstrip("/")
                self._heard[child] = (pose_from_transform_stamped(transform), at)
