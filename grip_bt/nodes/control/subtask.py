"""Another task as a node: the root of its file below a decorator that hands values in and out."""

from __future__ import annotations

from collections.abc import Callable

from py_trees import decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ..node import Node
from .container import Container, Face


class Subtask(Container, decorators.Decorator):
    """Ends as the exits say, which have every end of its child; then it hands out what was made.

    Args:
        face: what every container is made with; `enter` hands the inputs in.
        child: the root of the file.
        hand_out: called when it ends, before anybody learns of it; never after an interruption.
    """

    def __init__(self, face: Face, child: Behaviour, hand_out: Callable[[], None]):
        decorators.Decorator.__init__(self, face.name, child)
        self.take(face)
        self.hand_out = hand_out

    def update(self) -> Status:
        """Wait for the child; its end is an exit."""
        return self.decorated.status

    def leave(self, outcome: str, child: Node) -> None:
        """Hand out, and end."""
        self.hand_out()
        super().leave(outcome, child)
