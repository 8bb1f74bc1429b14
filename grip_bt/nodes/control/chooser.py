"""Switch, loop, for_each and cooldown as composites: a rule says who is ticked, py_trees' life cycle does the rest."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.base.values import Failure

from ..node import STATUS, Node
from .container import Container, Face
from .turns import Rule, Turn


class _Turns(composites.Composite):
    """How the chosen child is ticked: one at a time, and one choice a tick."""

    rule: Rule
    status: Status
    current_child: Any

    def tick(self) -> Iterator[Behaviour]:
        """Choose where nobody is chosen, tick who is, and go by how that ends."""
        if self.status != Status.RUNNING:
            self.current_child = None
            self.rule.begin()
        if self.current_child is None and not self.chosen():
            yield self
            return
        child = self.current_child
        assert child is not None, "somebody was chosen"
        yield from child.tick()
        self.follow(child)
        yield self

    def chosen(self) -> bool:
        """Choose a child; or end, and return False."""
        raise NotImplementedError

    def follow(self, child: Behaviour) -> None:
        """Go by the status of the child that was ticked."""
        raise NotImplementedError


class Chooser(Container, _Turns):
    """A container whose next child, or end, is chosen by a rule."""

    def __init__(self, face: Face, children: Iterable[Behaviour], rule: Rule):
        composites.Composite.__init__(self, face.name, list(children))
        self.take(face)
        self.rule = rule
        self.by_name: dict[str, Node] = {child.name: child for child in self.children}
        self.verdict: Failure | None = None

    def setup(self, **kwargs: Any) -> None:
        """Give the rule the run's context."""
        super().setup(**kwargs)
        self.rule.context = self.context

    def chosen(self) -> bool:
        """Ask the rule."""
        self.verdict = None
        try:
            turn: Turn = self.rule.choose()
        except Exception as error:
            raise NodeError(self.path, error) from error
        if turn.child is not None:
            self.current_child = self.by_name[turn.child]
            return True
        self.last_child, self.verdict, self.outcome = None, turn.failure, turn.outcome
        self.stop(STATUS[self.meaning[turn.outcome]])
        return False

    def follow(self, child: Behaviour) -> None:
        """Wait for the child; after its end choose again, at the next tick, or end likewise."""
        if child.status == Status.SUCCESS and self.rule.again:
            self.current_child = None
            self.context.wake()
        elif child.status != Status.RUNNING:
            self.stop(child.status)
            return
        self.status = Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Tell the rule."""
        self.rule.over()

    def reason(self) -> Failure | None:
        """Return why the rule ended it, or the child's reason."""
        return self.verdict or super().reason()


class Switch(Chooser):
    """The child whose case equals the value on entry."""


class Loop(Chooser):
    """The child again while a condition holds; one pass a tick."""


class ForEach(Chooser):
    """The child once for each item of a list, one a tick."""


class Cooldown(Chooser):
    """The child, unless it ended a short time ago."""
