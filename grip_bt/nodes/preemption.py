"""A parallel that asks its children to stop, as their leaves see it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol


class Asker(Protocol):
    """A container above that may ask what runs below it to come to an end."""

    path: str
    asked: bool


class AskedContext:
    """The run's context, in which a request of a container above counts as a preempt request.

    Args:
        context: the run's.
        askers: containers above that may ask; kept, not copied.
    """

    def __init__(self, context: Any, askers: Sequence[Asker]):
        self._context, self._askers = context, askers

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    @property
    def preempt_requested(self) -> bool:
        """Whether the run, or a container above, asks to come to an end."""
        return self._context.preempt_requested or any(asker.asked for asker in self._askers)


class AskedBefore:
    """A leaf's context as it was when it had been asked only so often, until that is over.

    Args:
        context: the leaf's.
        count: how often the run had been asked to come to an end.
        above: whether a container above had asked.

    Attributes:
        over: whether there is nothing to hide any more.
    """

    def __init__(self, context: Any, count: int, above: bool):
        self._context, self._count, self._above, self.over = context, count, above, False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    @property
    def preempt_requested(self) -> bool:
        """Whether the leaf was asked to come to an end."""
        if self.over:
            return bool(self._context.preempt_requested)
        return self._count > 0 or self._above

    @property
    def preempt_requests(self) -> int:
        """How often the run was asked."""
        return int(self._context.preempt_requests) if self.over else self._count
