"""Answers of rclpy's clients, heard without a detour.

rclpy's executor makes a task of each callback of a future that it ends, and wakes itself for it: the owner of an answer
hears of it one round of the executor later. And the owner, once woken, gets the interpreter's lock only when the
executor waits again, which takes it another round.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import Any

_log = logging.getLogger("grip.ros")


def when_done(future: Any, then: Callable[[Any], None]) -> None:
    """Have `then(future)` called when a service client's future ends, in the thread that ends it and at once."""

    def ended(done: Any) -> None:
        try:
            then(done)
        except Exception:  # noqa: BLE001 - it must not keep the future's other callbacks waiting
            _log.exception("what was to be done with an answer raised")

    # The executor says that it ends the future just before it does. One of rclpy's own, which may go: then the callback
    # becomes a task again.
    future._set_executor = _unheard
    future.add_done_callback(ended)


def give_way() -> None:
    """Let whoever was just woken by an answer run before the executor goes on; in the executor's thread."""
    time.sleep(0)  # gives the interpreter's lock away for a moment, and doesn't wait for anything


def _unheard(executor: Any) -> None:
    pass
