"""How slow this machine is just now: limits of time are promises of the machine that they were measured on."""

from __future__ import annotations

import time
from collections.abc import Callable

NOMINAL = 0.025
"""How long `_work` takes where the limits were measured, with nothing else to do [s]."""


def slowness(clock: Callable[[], float] = time.process_time) -> float:
    """Return how many times as long as there something takes here and now; at least 1.

    Args:
        clock: gives the time that is meant [s]: of this process, or `time.monotonic` where others hold it up too.
    """
    taken = []
    for _ in range(3):
        began = clock()
        _work()
        taken.append(clock() - began)
    return max(1.0, max(taken) / NOMINAL)


def is_within(taken: float, limit: float, clock: Callable[[], float] = time.process_time) -> bool:
    """Tell whether something took less than a limit, which is so much longer on a machine that is slower.

    Args:
        taken: how long it took by `clock` [s].
        limit: how long it may take where `NOMINAL` was measured [s].
        clock: as for `slowness`.
    """
    return taken < limit or taken < limit * slowness(clock)


def _work() -> object:
    table: dict[int, tuple[int, str]] = {}
    for i in range(100_000):
        table[i % 997] = (i * i, str(i))
    return table
