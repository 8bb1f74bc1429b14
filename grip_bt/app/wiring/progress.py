"""How a run that starts is reported: each part that came up, and what is waited for: silence looks like a fault."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Progress = Callable[[str, str], None]
"""Told `(part, detail)` as parts come up."""
SOON = 1.5
"""What takes no longer needs no words [s]."""


def silent(part: str, detail: str) -> None:
    """Say nothing."""


@contextmanager
def report_if_slow(progress: Progress, part: str, words: Callable[[], str], after: float = SOON) -> Iterator[None]:
    """Say what is waited for, once, where that takes its time; nothing is said after the end.

    Args:
        progress: told `(part, words)`, from another thread.
        part: which part of the run waits.
        words: asked what to say, when it is said.
        after: how long to be silent [s].
    """
    timer = threading.Timer(after, lambda: progress(part, words()))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()
