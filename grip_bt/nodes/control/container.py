"""What all containers share: a labelled end, the reason carried up, exits, and variables made anew on entry."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.ports import Context
from grip_bt.base.values import Failure
from grip_bt.task.edges import Edges

from ..node import STATUS, Node

PLAIN: Mapping[str, str] = {"success": "success", "failure": "failure"}


@dataclass(frozen=True)
class Face:
    """What a container is made with, whatever its kind.

    Attributes:
        name: its key in the document.
        path: its path in the task.
        meaning: each of its outcomes -> success or failure.
        exits: ends of children that end the container at once.
        enter: called when the container is entered anew; it resets the container's variables.
    """

    name: str
    path: str = "/"
    meaning: Mapping[str, str] = field(default_factory=lambda: PLAIN)
    exits: Edges = field(default_factory=Edges)
    enter: Callable[[], None] | None = None


class Container(Node):
    """Mixed in before a composite or decorator of py_trees, whose life cycle of children stays as it is."""

    exits_at_once = True
    """Whether an exit is taken as soon as the child has ended; a parallel waits until all children were ticked."""

    context: Context
    current_child: Any

    def take(self, face: Face) -> None:
        """Become what `face` says; called at the end of construction."""
        self.path, self.meaning, self.exits = face.path, dict(face.meaning), face.exits
        self.enter = face.enter
        self.last_child: Node | None = None

    def setup(self, **kwargs: Any) -> None:
        """Take the run's context, for its clock and for waking."""
        super().setup(**kwargs)
        self.context = kwargs["context"]

    def tick(self) -> Iterator[Behaviour]:
        """Tick as py_trees does, and leave by an exit when a child's end is mapped to one."""
        if self.status != Status.RUNNING:
            self.last_child = None
            self.begin()
            if self.enter is not None:
                self.enter()
        inner = super().tick()
        for node in inner:
            yield node
            if node.parent is self and node.status in (Status.SUCCESS, Status.FAILURE):
                self.last_child = node
                label = self.exit_of(node) if self.exits_at_once else None
                if label is not None:
                    inner.close()
                    self.leave(label, node)
                    yield self
                    return

    def exit_of(self, child: Node) -> str | None:
        """Return the outcome that the end of `child` is mapped to, if it is."""
        if not self.exits or child.outcome is None:
            return None
        return self.exits.target(child.name, child.outcome, child.code)

    def leave(self, outcome: str, child: Node) -> None:
        """End with `outcome` because of `child`, and halt what still runs."""
        for other in self.children:
            if other.status == Status.RUNNING:
                other.stop(Status.INVALID)
        if hasattr(self, "current_child"):
            self.current_child = child
        self.last_child, self.outcome = child, outcome
        self.stop(STATUS[self.meaning[outcome]])

    def conclude(self, status: Status) -> None:
        """Name the outcome and, when the container has failed, carry up the reason."""
        super().conclude(status)
        self.failure = self.reason() if status == Status.FAILURE else None

    def reason(self) -> Failure | None:
        """Return why this container fails: the reason of the child that decided it."""
        return self.last_child.failure if self.last_child is not None else None
