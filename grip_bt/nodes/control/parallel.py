"""All children at once. The rule that decides is a function of the children's ends alone; a state machine uses it too.

With `cancel: halt` the rule is read once a tick, after all unfinished children were ticked, and its decision interrupts
those still running. With `cancel: join` it is read when all children have ended: what comes out doesn't depend on who
ended first.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status

from grip_bt.values import Failure

from ..node import LABEL, STATUS
from .container import Container, Face
from .edges import Edges

Policy = Literal["all", "any"]
Cancel = Literal["halt", "join"]


@dataclass(frozen=True)
class End:
    """How one child of a parallel has ended."""

    child: str
    outcome: str
    meaning: str
    failure: Failure | None = None


def decide(policy: Policy, exits: Edges, ends: Sequence[End | None]) -> str | None:
    """Return the outcome that the children's ends decide, or None while nothing is decided.

    Args:
        policy: `all` or `any`.
        exits: the parallel's labelled exits; the first in the order of the children wins, before the policy.
        ends: one per child, in the children's order; None for a child that still runs.
    """
    for end in ends:
        if end is not None:
            code = end.failure.code if end.failure is not None else None
            label = exits.target(end.child, end.outcome, code)
            if label is not None:
                return label
    meanings = [end.meaning if end is not None else None for end in ends]
    if policy == "all":
        if "failure" in meanings:
            return "failure"
        return "success" if all(m == "success" for m in meanings) else None
    if "success" in meanings or not meanings:
        return "success"
    return "failure" if all(m == "failure" for m in meanings) else None


def first_reason(ends: Sequence[End | None], exits: Edges, outcome: str) -> Failure | None:
    """Return the reason of a parallel that failed with `outcome`: that of the first child which accounts for it."""
    for end in ends:
        if end is None:
            continue
        code = end.failure.code if end.failure is not None else None
        if exits.target(end.child, end.outcome, code) == outcome:
            return end.failure
    for end in ends:
        if end is not None and end.meaning == "failure":
            return end.failure
    return None


class _Rounds(composites.Parallel):
    """How the children are ticked; the rule itself is `settle`."""

    def tick(self) -> Iterator[Behaviour]:
        """Tick every unfinished child, in order; then read the rule."""
        if self.status != Status.RUNNING:
            for child in self.children:
                if child.status != Status.INVALID:
                    child.stop(Status.INVALID)
            self.current_child = None
            self.initialise()
        for child in self.children:
            if child.status not in LABEL:
                yield from child.tick()
        status = self.settle()
        if status != Status.RUNNING:
            self.stop(status)
        self.status = status
        yield self

    def settle(self) -> Status:
        """Read the rule after all children were ticked."""
        raise NotImplementedError


class Parallel(Container, _Rounds):
    """Ticks every unfinished child once a tick, in order, and a finished one not again."""

    exits_at_once = False

    def __init__(
        self,
        face: Face,
        children: Iterable[Behaviour],
        policy: Policy = "all",
        cancel: Cancel = "halt",
    ):
        shown = ParallelPolicy.SuccessOnAll() if policy == "all" else ParallelPolicy.SuccessOnOne()
        composites.Parallel.__init__(self, face.name, shown, list(children))
        self.take(face)
        self.rule, self.cancel = policy, cancel

    def settle(self) -> Status:
        """Decide, and remember which child accounts for the end."""
        ends = self.ends()
        self.current_child = self.children[-1] if self.children else None
        if self.cancel == "join" and None in ends:
            return Status.RUNNING
        outcome = decide(self.rule, self.exits, ends)
        if outcome is None:
            return Status.RUNNING
        self.outcome = outcome
        return STATUS[self.meaning[outcome]]

    def ends(self) -> list[End | None]:
        """Return how each child has ended in this activation; None for one that still runs."""
        return [
            End(c.name, c.outcome, c.meaning[c.outcome], c.failure) if c.status in LABEL else None
            for c in self.children
        ]

    def reason(self) -> Failure | None:
        """Return the reason of the first child that accounts for the outcome."""
        return first_reason(self.ends(), self.exits, self.outcome or "failure")
