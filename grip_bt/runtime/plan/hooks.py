"""What our containers add around the tick of a composite or decorator of py_trees."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .parts import F, R, S, Visit

Ended = Callable[[Any], bool]
"""Called with a child of a container that was just ticked; returns whether the container has ended by an exit."""


def entering(node: Any) -> Callable[[], None]:
    """Return what a container does before it ticks its children."""

    def enter() -> None:
        if node.status is not R:
            node.last_child = None
            node.begin()
            if node.enter is not None:
                node.enter()

    return enter


def leaving(node: Any, visit: Visit | None) -> Ended:
    """Return what a container does after each child."""

    def ended(kid: Any) -> bool:
        if kid.status is not S and kid.status is not F:
            return False
        node.last_child = kid
        label = node.exit_of(kid) if node.exits_at_once and node.exits else None
        if label is None:
            return False
        node.leave(label, kid)
        if visit is not None:
            visit(node)
        return True

    return ended
