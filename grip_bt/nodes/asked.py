"""A parallel that asks its children to stop, as their leaves see it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol


class Asker(Protocol):
    """A container above that may ask what runs below it to come to an end."""

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
