"""Ticks that hang are noticed: a thread of its own looks at how long each takes."""

from __future__ import annotations

import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping

from grip_bt.base.errors import HungError, NodeError
from grip_bt.compilers.behaviour_state import drive
from grip_bt.nodes.leaf import Leaf
from grip_bt.runtime.pacing import Pacing
from grip_bt.runtime.stopping import code_running

LIMIT = 10.0
"""How long [s] one tick may take by default; `update` never blocks, so that this is far more than any needs."""


class Watchdog:
    """Looks at a run's ticks, of `limit` [s] at most, from a thread of its own, a few times within that.

    `bark` is called once with the error, a `NodeError` of a `HungError`, and where the code is, as a traceback.
    """

    def __init__(
        self, pacing: Pacing, leaves: Mapping[str, Leaf], limit: float, bark: Callable[[NodeError, str], None]
    ):
        self._pacing, self._leaves, self._limit, self._bark = pacing, leaves, limit, bark
        self._over = threading.Event()

    def start(self) -> None:
        threading.Thread(target=self._watch, name="grip_watchdog", daemon=True).start()

    def stop(self) -> None:
        self._over.set()

    def _watch(self) -> None:
        while not self._over.wait(self._limit / 4):
            late = time.monotonic() - self._limit
            for thread, began in list(self._pacing.begun.items()):
                if began < late and _ticks(thread) and self._pacing.begun.get(thread) == began:
                    inside = code_running(self._leaves, [thread])
                    path, where = next(iter(inside.items()), ("/", "a tick"))
                    frame = sys._current_frames().get(thread)
                    trace = "".join(traceback.format_stack(frame)) if frame is not None else ""
                    self._bark(NodeError(path, HungError(where, self._limit)), trace)
                    return


def _ticks(thread: int) -> bool:
    """Tell whether a thread is inside a tick: in a loop that drives a behaviour, and not waiting for its turn.

    Entries of threads that wait for others, or that have ended, are old and mean nothing.
    """
    frame, codes = sys._current_frames().get(thread), set()
    while frame is not None:
        codes.add(frame.f_code)
        frame = frame.f_back
    return bool(codes & _LOOPS) and not codes & _WAITING


_LOOPS = {drive.__code__}
"""The loop that ticks: a tree, or a state of a machine."""
_WAITING = {Pacing.turn.__code__, Pacing.rest.__code__, Pacing.hold.__code__}
