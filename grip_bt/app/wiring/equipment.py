"""What serves several runs of one process; importing it takes no time."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, TypeVar, cast

from grip_bt.base.files import Closing

T = TypeVar("T")


class Equipment(Closing):
    """What is slow to start and can serve one run after the other: planner, simulator, servers of components.

    Args:
        lasting: whether it outlives the run; whoever made it closes it then.
    """

    def __init__(self, lasting: bool = False):
        self.lasting = lasting
        self._parts: dict[str, tuple[object, Any, ExitStack]] = {}

    def get(
        self,
        name: str,
        made_of: object,
        start: Callable[[ExitStack], T],
        usable: Callable[[T], bool] = lambda part: True,
    ) -> T:
        """Return a part, started unless it is there, made of the same and usable; its stack closes it."""
        if name in self._parts:
            before, part, stack = self._parts[name]
            if before == made_of and usable(part):
                return cast(T, part)
            del self._parts[name]
            stack.close()
        with ExitStack() as stack:
            part = start(stack)
            self._parts[name] = made_of, part, stack.pop_all()
        return part

    def close(self) -> None:
        """Close all, the last first. Harmless when repeated."""
        while self._parts:
            self._parts.popitem()[1][2].close()
