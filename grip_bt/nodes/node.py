"""Nodes of a run, and whoever wants to know what they do: the journal, a trace in a test, a live view."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, Protocol

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.base.ports import Context
from grip_bt.base.values import Failure
from grip_bt.task.model import AnyNode


class Observer:
    """Told of each activation of each node, in the thread that ticks it; must return quickly and never raise."""

    def entered(self, path: str) -> None:
        """An activation begins."""

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """An activation ended with one of the node's outcomes."""

    def interrupted(self, path: str) -> None:
        """An activation was halted before it had an outcome."""

    def message(self, path: str, text: str) -> None:
        """A running node says how it goes."""

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        """The node at `path` wrote a variable."""


SILENT = Observer()


class Observers(Observer):
    """Several observers as one; each is told in turn."""

    def __init__(self, *observers: Observer):
        for event in ("entered", "ended", "interrupted", "message", "wrote"):
            setattr(self, event, partial(_tell, [getattr(observer, event) for observer in observers]))


def _tell(listeners: Sequence[Callable[..., None]], *what: object) -> None:
    for listener in listeners:
        listener(*what)


STATUS = {"success": Status.SUCCESS, "failure": Status.FAILURE}
LABEL = {Status.SUCCESS: "success", Status.FAILURE: "failure"}


class Node(Behaviour):
    """Mixed in before a class of py_trees.

    Attributes:
        path: the node's path in the task; `/` for the root.
        meaning: each outcome that the node can end with -> `success` or `failure`.
        outcome: the label of the last end, None while running or after an interruption.
        document: what it was made of; None where it wasn't compiled.
    """

    status: Status
    feedback_message: str
    path: str = ""
    meaning: Mapping[str, str] = {"success": "success", "failure": "failure"}
    outcome: str | None = None
    failure: Failure | None = None
    active: bool = False
    document: AnyNode | None = None
    observer: Observer = SILENT

    @property
    def code(self) -> str | None:
        return self.failure.code if self.failure is not None else None

    def begin(self) -> None:
        """Forget the last end and report that an activation begins."""
        self.outcome, self.failure, self.active = None, None, True
        self.observer.entered(self.path)

    def conclude(self, status: Status) -> None:
        """Settle `outcome` and `failure` of an activation that ends with `status`."""
        if self.outcome is None:
            self.outcome = "success" if status is Status.SUCCESS else "failure"

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End an activation, or interrupt it (INVALID); an interrupted one has no outcome."""
        if new_status in LABEL:
            self.conclude(new_status)
        else:
            self.outcome, self.failure = None, None
        try:
            super().stop(new_status)
        finally:
            self.report()

    def report(self) -> None:
        if self.active:
            self.active = False
            if self.outcome is None:
                self.observer.interrupted(self.path)
            else:
                self.observer.ended(self.path, self.outcome, self.failure)


@dataclass(frozen=True)
class Condition:
    """An expression that is true or false.

    Attributes:
        watch: has a function called after each write of a variable that it reads.
    """

    text: str
    holds: Callable[[], bool]
    watch: Callable[[Callable[[], None]], None]

    def refusal(self, code: str) -> Failure:
        return Failure(code, f"`{self.text}` is false")


class Conditional(Node):
    """Mixed in before a leaf or container: where the condition is false on entry, it fails without having begun."""

    precondition: Condition

    def tick(self) -> Iterator[Behaviour]:
        if self.status != Status.RUNNING and self.refused():
            yield self
        else:
            yield from super().tick()

    def refused(self) -> bool:
        """Tell whether the condition is false, on entry; then it has failed."""
        try:
            holds = self.precondition.holds()
        except Exception as error:
            self.begin()
            self.stop(Status.INVALID)
            raise NodeError(self.path, error) from error
        if not holds:
            self.begin()
            self._refuse()
        return not holds

    def _refuse(self) -> None:
        """End without `terminate`, since nothing was initialised."""
        self.outcome, self.failure = "failure", self.precondition.refusal("precondition")
        self.feedback_message = str(self.failure)
        self.status, self.active = Status.FAILURE, False
        self.observer.ended(self.path, self.outcome, self.failure)


def conditional(node: Node, condition: Condition, meaning: Mapping[str, str]) -> None:
    """Give a node, in place, a precondition; `meaning` holds its outcomes, with `failure` among them."""
    node.__class__ = _conditional(type(node))  # type: ignore[arg-type]  # classes can be hashed
    assert isinstance(node, Conditional)
    node.precondition, node.meaning = condition, dict(meaning)


@cache
def _conditional(cls: type[Node]) -> Any:
    return type(cls.__name__, (Conditional, cls), {"__module__": cls.__module__, "__doc__": cls.__doc__})


def halt(root: Behaviour) -> list[tuple[str, Exception]]:
    """Interrupt everything below and including `root`, at once, and leave nothing running.

    Works leaf by leaf, since after an exception a composite's status may not show what runs below it.

    Returns:
        What was raised while stopping, with the path of the node; the rest was stopped all the same.
    """
    errors: list[tuple[str, Exception]] = []
    for node in list(root.iterate()):
        if node.status == Status.RUNNING or getattr(node, "active", False):
            try:
                node.stop(Status.INVALID)
            except Exception as error:  # noqa: BLE001 - one broken leaf must not keep others from being stopped
                node.status = Status.INVALID
                errors.append((getattr(node, "path", node.name), error))
    return errors


class Asker(Protocol):
    """A container above that may ask what runs below it to come to an end."""

    path: str
    asked: bool


class AskedContext:
    """A run's context, in which `asked()` tells whether there is a preempt request."""

    def __init__(self, context: Context, asked: Callable[[], bool]):
        self._context, self._asked = context, asked

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    @property
    def preempt_requested(self) -> bool:
        return self._asked()


class AskedBefore(AskedContext):
    """A leaf's context as it was when the run had been asked so often, and a container above or not, until `over`."""

    def __init__(self, context: Context, count: int, above: bool):
        super().__init__(context, lambda: context.preempt_requested if self.over else count > 0 or above)
        self._count, self.over = count, False

    @property
    def preempt_requests(self) -> int:
        return int(getattr(self._context, "preempt_requests", 0)) if self.over else self._count
