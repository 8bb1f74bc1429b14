"""Messages of several topics that belong to one moment: a pure matcher, without ROS."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Any

KEPT = 30
"""Messages of each topic that are kept while others are awaited."""


class Synchroniser:
    """Finds the first set of messages, one of each topic, whose stamps lie close together.

    Args:
        topics: their names.
        slop: how far the stamps of a set may be apart [s].
    """

    def __init__(self, topics: Iterable[str], slop: float):
        self.slop = slop
        self._kept: dict[str, deque[tuple[float, Any]]] = {topic: deque(maxlen=KEPT) for topic in topics}

    def add(self, topic: str, stamp: float, message: Any) -> dict[str, Any] | None:
        """Add a message; return the set that it completes, the one that lies closest together, or None.

        Args:
            topic: where it came from.
            stamp: when it was taken [s].
            message: handed out as it is.
        """
        self._kept[topic].append((stamp, message))
        nearest = {}
        for name, kept in self._kept.items():
            if not kept:
                return None
            nearest[name] = (stamp, message) if name == topic else min(kept, key=lambda entry: abs(entry[0] - stamp))
        stamps = [entry[0] for entry in nearest.values()]
        if max(stamps) - min(stamps) > self.slop:
            return None
        return {name: entry[1] for name, entry in nearest.items()}

    def silent(self) -> list[str]:
        """Return the topics on which nothing came."""
        return [topic for topic, kept in self._kept.items() if not kept]

    def describe(self) -> str:
        """Say what came so far, for the error of a wait that ends in vain."""
        if silent := self.silent():
            return f"nothing came on {', '.join(silent)}"
        last = {topic: kept[-1][0] for topic, kept in self._kept.items()}
        apart = max(last.values()) - min(last.values())
        return f"the last stamps are {apart:.3f} s apart, at most {self.slop:.3f} s are allowed"
