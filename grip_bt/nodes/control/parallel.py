"""All children at once. The rule that decides is a function of the children's ends alone; a state machine uses it too.

With `cancel: halt` the rule is read once a tick, after all unfinished children were ticked, and its decision interrupts
those still running. With `cancel: join` it is read when all children have ended: what comes out doesn't depend on who
ended first.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status

from grip_bt.base.values import Failure
from grip_bt.task.edges import Edges

from ..node import LABEL, STATUS
from .container import Container, Face

Policy = Literal["all", "any"]
Cancel = Literal["halt", "ask", "join"]
WaitFor = Literal["all", "any"] | int | Sequence[str] | None


@dataclass(frozen=True)
class End:
    """How one child of a parallel has ended."""

    child: str
    outcome: str
    meaning: str
    failure: Failure | None = None

    def labels(self) -> set[str]:
        """Return how a rule may call this end."""
        return {self.outcome} if self.failure is None else {self.outcome, f"{self.outcome}.{self.failure.code}"}


@dataclass(frozen=True)
class Match:
    """A rule of a parallel.

    Attributes:
        then: the outcome that it leads to.
        when: child -> the labels, `outcome` or `outcome.code`, of which it has to have ended with one.
        at_least: how many children have to have ended with the meaning `ends`.
        ends: `success` or `failure`.
    """

    then: str
    when: Mapping[str, Collection[str]] = field(default_factory=dict)
    at_least: int | None = None
    ends: str = "success"

    def holds(self, ends: Sequence[End], complete: bool) -> bool:
        """Tell whether it holds for the children that have ended; `complete`: nobody is waited for any more."""
        if not self.when and self.at_least is None:
            return complete
        labels = {end.child: end.labels() for end in ends}
        wanted = all(not labels.get(child, set()).isdisjoint(any_of) for child, any_of in self.when.items())
        return wanted and sum(end.meaning == self.ends for end in ends) >= (self.at_least or 0)


@dataclass(frozen=True)
class Ruling:
    """How a parallel is decided: exits come first, then the rules in their order, then the policy.

    Attributes:
        policy: `all` or `any`.
        exits: ends of children -> outcomes.
        rules: in the document's order.
        wait_for: who has to have ended before anything is decided.
    """

    policy: Policy = "all"
    exits: Edges = field(default_factory=Edges)
    rules: Sequence[Match] = ()
    wait_for: WaitFor = None

    def outcome(self, ends: Sequence[End | None]) -> str | None:
        """Return what the children's ends decide, or None; one end per child, None for one that still runs."""
        if not self._waited(ends):
            return None
        there = [end for end in ends if end is not None]
        complete = self.wait_for is not None or len(there) == len(ends)
        if not self.rules and self.wait_for is None:
            return decide(self.policy, self.exits, ends)
        for end in there:
            label = self.exits.target(end.child, end.outcome, end.failure.code if end.failure else None)
            if label is not None:
                return label
        matching = next((rule.then for rule in self.rules if rule.holds(there, complete)), None)
        return matching or (decide(self.policy, Edges(), there) if complete else None)

    def _waited(self, ends: Sequence[End | None]) -> bool:
        ended = [end.child for end in ends if end is not None]
        match self.wait_for:
            case _ if len(ended) == len(ends):
                return True
            case None:
                return True
            case "all":
                return False
            case "any":
                return bool(ended)
            case int(number):
                return len(ended) >= number
            case names:
                return set(names) <= set(ended)


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

    retick = False
    status: Status
    current_child: Any

    def tick(self) -> Iterator[Behaviour]:
        """Tick every unfinished child, in order, or every child; then read the rule."""
        if self.status != Status.RUNNING:
            for child in self.children:
                if child.status != Status.INVALID:
                    child.stop(Status.INVALID)
            self.current_child = None
            self.initialise()
        for child in self.children:
            if self.retick or child.status not in LABEL:
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
    """Ticks every unfinished child once a tick, in order, and a finished one again only with `retick`."""

    exits_at_once = False

    def __init__(
        self,
        face: Face,
        children: Iterable[Behaviour],
        ruling: Ruling,
        cancel: Cancel = "halt",
        retick: bool = False,
    ):
        shown = ParallelPolicy.SuccessOnAll() if ruling.policy == "all" else ParallelPolicy.SuccessOnOne()
        composites.Parallel.__init__(self, face.name, shown, list(children))
        self.take(face)
        self.ruling, self.cancel, self.retick = ruling, cancel, retick
        self.asked = False
        self.decided: tuple[str, Failure | None] | None = None

    def initialise(self) -> None:
        """Decide anew."""
        self.asked, self.decided = False, None

    def settle(self) -> Status:
        """Decide, and remember which child accounts for the end."""
        ends = self.ends()
        self.current_child = self.children[-1] if self.children else None
        if self.cancel == "join" and None in ends:
            return Status.RUNNING
        if self.decided is None:
            outcome = self.ruling.outcome(ends)
            if outcome is None:
                return Status.RUNNING
            self.decided = outcome, first_reason(ends, self.exits, outcome)
        if self.cancel == "ask" and None in ends:
            self._ask()
            return Status.RUNNING
        self.outcome = self.decided[0]
        return STATUS[self.meaning[self.outcome]]

    def _ask(self) -> None:
        """Request the children that still run to stop; their leaves see it as a preempt request."""
        if not self.asked:
            self.asked = True
            assert self.decided is not None, "it asks because it is decided"
            # Said, since nothing else tells that it was decided in this tick already, and by these children.
            self.observer.message(self.path, f"{self.decided[0]}, when the others have stopped")
            self.context.wake()

    def ends(self) -> list[End | None]:
        """Return how each child has ended in this activation; None for one that still runs."""
        return [
            End(c.name, c.outcome, c.meaning[c.outcome], c.failure) if c.status in LABEL else None
            for c in self.children
        ]

    def reason(self) -> Failure | None:
        """Return the reason of the first child that accounts for the outcome."""
        return self.decided[1] if self.decided is not None else None
