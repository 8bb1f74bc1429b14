"""When a program that uses smach_ros on rclpy is over: its context was shut down, or somebody interrupted it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any

from rclpy.utilities import get_default_context


class Shutdown:
    """Whether the program is being shut down, and what to do then.

    A program that has called `rclpy.init` is shut down with rclpy's own context. In one that hasn't, as programs in
    ROS 1's style, hooks are called at the first SIGINT or SIGTERM, as rospy does; a second one acts as ever.
    """

    def __init__(self) -> None:
        self._hooks: list[Callable[[], None]] = []
        self._over = threading.Event()
        self._context_was_up = False
        self._previous: dict[int, Any] = {}

    def over(self) -> bool:
        """Tell whether it is over."""
        up = bool(get_default_context().ok())
        self._context_was_up = self._context_was_up or up
        return self._over.is_set() or (self._context_was_up and not up)

    def add(self, hook: Callable[[], None]) -> None:
        """Call `hook()` when a shutdown was asked for."""
        context = get_default_context()
        if context.ok():
            self._context_was_up = True
            context.on_shutdown(hook)
            return
        self._hooks.append(hook)
        if not self._previous and threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                self._previous[number] = signal.signal(number, self._interrupted)

    def wait(self, seconds: float) -> None:
        """Wait; a shutdown by signal ends it."""
        self._over.wait(max(0.0, seconds))

    def _interrupted(self, number: int, frame: FrameType | None) -> None:
        for signal_number, previous in self._previous.items():
            signal.signal(signal_number, previous)
        # Hooks wait for machines, and the main thread may be what executes them.
        threading.Thread(target=self._run_hooks, name="smach-shutdown").start()

    def _run_hooks(self) -> None:
        try:
            for hook in self._hooks:
                hook()
        finally:
            self._over.set()
