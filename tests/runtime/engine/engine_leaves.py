"""Nodes that write down what they see, for comparing two ways of ticking the same tree."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from py_trees import behaviour, composites, decorators
from py_trees.common import Status

S, F, R, INVALID = Status.SUCCESS, Status.FAILURE, Status.RUNNING, Status.INVALID


class Log(list[tuple[Any, ...]]):
    """What the nodes of one tree have seen.

    Args:
        board: the tree's part of the blackboard.
    """

    def __init__(self, board: str = "alone"):
        super().__init__()
        self.board = board


def seen_from(node: behaviour.Behaviour) -> tuple[Any, ...]:
    """What a callback of `node` may look at."""
    parent = node.parent
    pointed = getattr(parent, "current_child", None)
    return node.status, parent.status if parent else None, pointed.name if pointed else None


class Plain(behaviour.Behaviour):
    """Overrides `update` alone, and looks at nothing."""

    def __init__(self, name: str, script: list[Any], log: Log):
        super().__init__(name)
        self.script, self.log, self.k = script, log, 0

    def result(self) -> Any:
        value = self.script[self.k % len(self.script)]
        self.k += 1
        if value == "raise":
            raise ValueError(f"{self.name} breaks")
        return value

    def update(self) -> Status:
        return self.result()


class Told(Plain):
    """Says how often it was called."""

    def update(self) -> Status:
        self.log.append(("update", self.name))
        self.feedback_message = f"{self.k}"
        return self.result()


class Looking(Plain):
    """Overrides `update` alone, and looks at its own status, its parent's, and where the parent points."""

    def update(self) -> Status:
        self.log.append(("update", self.name, *seen_from(self)))
        return self.result()


class Seeing(Plain):
    """Overrides everything, and looks at its own status and its parent's."""

    def initialise(self) -> None:
        self.log.append(("initialise", self.name, *seen_from(self)))

    def update(self) -> Status:
        self.log.append(("update", self.name, *seen_from(self)))
        return self.result()

    def terminate(self, new_status: Status) -> None:
        self.log.append(("terminate", self.name, new_status, *seen_from(self)))


class Ending(Plain):
    """Overrides `terminate`, which raises now and then."""

    def terminate(self, new_status: Status) -> None:
        self.log.append(("terminate", self.name, new_status, *seen_from(self)))
        if self.k % 7 == 6:
            raise KeyError(self.name)


class Stopping(Told):
    """Overrides `stop`."""

    def stop(self, new_status: Status) -> None:
        self.log.append(("stop", self.name, new_status))
        super().stop(new_status)


class Ticking(Told):
    """Overrides `tick`, and does more after it has yielded itself."""

    def tick(self) -> Iterator[behaviour.Behaviour]:
        self.log.append(("tick", self.name))
        yield from super().tick()
        self.log.append(("ticked", self.name))
        if self.k % 5 == 4:
            self.status = F


class LoggedSequence(composites.Sequence):
    log: Log

    def initialise(self) -> None:
        self.log.append(("initialise", self.name, *seen_from(self)))

    def terminate(self, new_status: Status) -> None:
        self.log.append(("terminate", self.name, new_status, *seen_from(self)))


class LoggedSelector(composites.Selector):
    log: Log

    def initialise(self) -> None:
        self.log.append(("initialise", self.name, *seen_from(self)))

    def terminate(self, new_status: Status) -> None:
        self.log.append(("terminate", self.name, new_status, *seen_from(self)))


class LoggedParallel(composites.Parallel):
    log: Log

    def initialise(self) -> None:
        self.log.append(("initialise", self.name, *seen_from(self)))

    def terminate(self, new_status: Status) -> None:
        self.log.append(("terminate", self.name, new_status, *seen_from(self)))


class LoggedInverter(decorators.Inverter):
    log: Log

    def initialise(self) -> None:
        self.log.append(("initialise", self.name, *seen_from(self)))

    def terminate(self, new_status: Status) -> None:
        self.log.append(("terminate", self.name, new_status, *seen_from(self)))


class Backwards(composites.Composite):
    """A composite of somebody's own: children from the last to the first until one succeeds."""

    def tick(self) -> Iterator[behaviour.Behaviour]:
        if self.status != R:
            self.initialise()
        for child in reversed(self.children):
            yield from child.tick()
            self.current_child = child
            if child.status != F:
                if child.status != R:
                    self.stop(child.status)
                self.status = child.status
                yield self
                return
        self.stop(F)
        yield self


class Reckless(composites.Sequence):
    """A sequence that overrides `stop`."""

    log: Log

    def stop(self, new_status: Status = INVALID) -> None:
        self.log.append(("stop", self.name, new_status))
        super().stop(new_status)
