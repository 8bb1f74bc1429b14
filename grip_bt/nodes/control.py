"""Leaves that decide over other nodes: BehaviorTree.CPP's control nodes and decorators, written in Python."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.types import Value

from .container import KindNode
from .leaf import Leaf

SKIPPED = "skipped"


class Child:
    """A node as the code of a `Control` sees it.

    Attributes:
        ended: whether its last activation has ended and it wasn't reset since: not IDLE, as BehaviorTree.CPP says.
    """

    def __init__(self, node: Value):
        self.node, self.ended = node, False

    @property
    def running(self) -> bool:
        """Whether it is in the middle of something."""
        return bool(self.node.status is Status.RUNNING)

    def tick(self) -> str:
        """Tick it; return `running`, `success`, `failure` or `skipped`, which is an outcome of that name."""
        node = self.node
        if isinstance(node, ControlNode):
            node.decider.kept = self.ended
        node.tick_once()
        if node.status is Status.RUNNING:
            return "running"
        self.ended = node.outcome != SKIPPED
        return str(node.meaning[node.outcome]) if self.ended else SKIPPED

    def halt(self) -> None:
        """Interrupt it where it runs, and have it begin anew."""
        self.ended = False
        if self.node.status is not Status.INVALID:
            self.node.stop(Status.INVALID)


class Control(Leaf):
    """The first child of a `control`.

    Authors override `decide`, which never blocks, and where they need to `initialise` and `halted`.

    Attributes:
        below: the other children, in order.
        kept: whether its last activation has ended and whoever ticks it has not reset it since.
    """

    below: Sequence[Child] = ()
    kept = False

    def decide(self) -> str:
        """Tick and halt children; return `running`, or with which outcome to end."""
        raise NotImplementedError(f"{type(self).__name__}.decide")

    def halted(self) -> None:
        """Note that it was interrupted; the children still are as they were, and are halted afterwards."""

    def get(self, port: str) -> Value:
        """Return what a port holds: the variable that it is bound to, or the literal of the parameter of that name."""
        return self.read(port) if port in self.readers else self.params.get(port)

    def put(self, port: str, value: object) -> None:
        """Write an output before the end, where it is bound."""
        if port in self.writers:
            self.writers[port](value)

    def update(self) -> Status:
        end = self.decide()
        if end == "running":
            return self.running()
        if self.meaning.get(end) == "failure":  # for the reason of whoever has failed
            self.failure = next((each.node.failure for each in reversed(self.below) if each.node.failure), None)
        return self.end(end)

    def terminate(self, new_status: Status) -> None:
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self.halted()


class ControlNode(KindNode):
    """The behaviour of a `control`."""

    below: Sequence[Child] = ()

    @property
    def decider(self) -> Control:
        """The leaf that decides."""
        leaf: Control = self.children[0]
        return leaf

    def tick(self) -> Iterator[Behaviour]:
        if self.status is not Status.RUNNING:
            self.opening()
            if [child.node for child in self.below] != self.children[1:]:
                self.below = [Child(node) for node in self.children[1:]]
            self.decider.below = self.below
        yield from self.decider.tick()
        self.running = tuple(i for i, child in enumerate(self.children) if child.status is Status.RUNNING)
        step = None if 0 in self.running else self.after(0, self.decider)
        if step is None:
            self.status, self.current_child = Status.RUNNING, self.decider
        else:
            self.land(step)
        yield self

    def stop(self, new_status: Status = Status.INVALID) -> None:
        super().stop(new_status)
        for child in self.below:
            child.halt()
