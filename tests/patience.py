"""Waiting for what surely comes. Limits only end a hang: no result of a slow or busy machine depends on them."""

from __future__ import annotations

import time
from collections.abc import Callable

PATIENCE = 400.0
"""How long a test waits for one thing that surely comes [s]."""


def until(condition: Callable[[], object], told: str = "it never happens", within: float = PATIENCE) -> None:
    """Wait until a condition holds.

    Args:
        condition: asked again and again.
        told: what is said when it doesn't hold `within` [s].
    """
    deadline = time.monotonic() + within
    while not condition():
        assert time.monotonic() < deadline, told
        time.sleep(0.01)


class Ahead:
    """Stands for the module `time` where time-outs are counted: as real time, but for what a test skips of it.

    A time-out that a test waits for in real time may come too soon for a slow machine, and costs its time on all.
    """

    def __init__(self) -> None:
        self._skipped = 0.0

    def skip(self, seconds: float) -> None:
        """Have so much time passed at once [s]."""
        self._skipped += seconds

    def monotonic(self) -> float:
        """Return the time [s]."""
        return time.monotonic() + self._skipped
