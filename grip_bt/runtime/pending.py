"""Calls and motions under way: whether simulated time stands still for one, who works on it, how its end is told."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation

Patience = bool | Callable[[], dict[str, float]]
"""Whether a call surely ends, however long that takes; or what tells who works on it, see `thought_of`."""
THINKING = 0.3
"""Who works on a call thinks where a thread of theirs ran, or waited for a processor, for this part of the time."""
_log = logging.getLogger(__name__)


@dataclass(eq=False)
class Pending:
    """Something under way that will end.

    Attributes:
        key: orders what is pending as it was asked for; what code in a worker asks for comes after that code.
        holds: whether time stands still for it; not for a motion, nor for what was waited for too long.
        patient: whether that lasts until it ends; else while threads work on it, for longer than was `known`.
        finish: tells the end; None before it.
        waits: for what the code that works for it waits.
        waited: whether that took time since this was looked at, which is no time of its own.
    """

    key: tuple[int, ...]
    holds: bool
    patient: Patience
    asked: float
    whole: Operation[Any] | None = None
    finish: Callable[[], None] | None = None
    waits: list[Operation[Any]] = field(default_factory=list)
    waited: bool = False
    count: int = 0
    known: dict[str, float] = field(default_factory=dict)

    @property
    def busy(self) -> bool:
        return self.whole is not None and self.whole.busy

    @property
    def ready(self) -> bool:
        """Whether its end can be told; not while code goes on for which time stands still."""
        return self.finish is not None and not (self.holds and self.busy)

    def holds_now(self) -> bool:
        """Tell whether time stands still for it; not while it waits for something else."""
        if self.waits and not any(operation.done() for operation in self.waits):
            return False
        if self.waited:
            self.waited, self.asked = False, time.monotonic()
        return self.holds

    def look_again(self, passed: float) -> None:
        """Hold time from now on only if somebody has thought about it for long enough of what passed [s of ours]."""
        before, self.known = self.known, self.patient() if callable(self.patient) else {}
        most = max((spent - before.get(thread, 0.0) for thread, spent in self.known.items()), default=0.0)
        self.asked, self.holds = self.asked + passed, most > THINKING * passed

    def tell(self, canceled: bool = False) -> None:
        """Tell its end; of a call that was cancelled meanwhile, that, whichever was quicker."""
        assert self.finish is not None, "it has ended"
        assert self.whole is not None, "it has ended"
        try:
            if self.holds and (canceled or self.whole.cancel_asked):
                self.whole.fail(CanceledError("canceled"))
            self.finish()
        except Exception:  # noqa: BLE001 - one callback mustn't keep other operations from ending
            _log.exception("a callback of an operation failed")


def thought_of(process: int, thread: int | str = "*") -> dict[str, float]:
    """Return for how long threads of a process and of all that it started ran or waited for a processor [s] (Linux)."""
    found: dict[str, float] = {}
    for task in Path(f"/proc/{process}/task").glob(str(thread)):
        with suppress(OSError, ValueError):  # it has ended meanwhile
            found[task.name] = 1e-9 * sum(map(int, (task / "schedstat").read_text().split()[:2]))
            for child in (task / "children").read_text().split():
                found |= thought_of(int(child))
    return found
