"""Preempting machines when ROS shuts down."""

from __future__ import annotations

from typing import Any

from grip_bt.smach_compat._settings import hooks

from ._connection import ros

__all__ = ["set_preempt_handler"]

POLL = 1.0
"""How often a machine that was asked to stop is looked at [s]."""


def set_preempt_handler(sc: Any) -> None:
    """Ask a container to stop when ROS is asked to shut down, and wait until it has stopped."""

    def handler() -> None:
        sc.request_preempt()
        running = getattr(sc, "is_running", lambda: False)  # a Concurrence has none, and upstream fails there
        while running():
            hooks.loginfo("Received a shutdown request: asked the state machine to stop, waiting for it.")
            ros().sleep(POLL)

    ros().on_shutdown(handler)
