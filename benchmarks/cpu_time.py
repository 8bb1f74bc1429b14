"""CPU time of a call."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

BUDGET = 0.1


def seconds(call: Callable[[], Any], budget: float = BUDGET) -> float:
    """Return the CPU time [s] of one call in this thread, from as many as fit into `budget` [s]."""
    for _ in range(3):
        call()
    calls, batch, began, spent = 0, 1, time.thread_time(), 0.0
    while spent < budget:
        for _ in range(batch):
            call()
        calls += batch
        spent = time.thread_time() - began
        if spent < budget / 20:
            batch *= 2
    return spent / calls
