"""Who is run next in a state of SMACH that chooses: by a value, or by a condition."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from grip_bt.base.evaluation import same_literal
from grip_bt.base.ports import Context
from grip_bt.base.values import Failure

from .condition import Condition


@dataclass(frozen=True)
class Turn:
    """What comes next: a child, or an end.

    Attributes:
        child: its name; None for an end.
        outcome: of an end.
        failure: the reason of an end with `failure`.
    """

    child: str | None = None
    outcome: str = "success"
    failure: Failure | None = None


class Rule:
    """What one container asks; it lasts for a run.

    Attributes:
        again: whether a child's success leads back to `choose`.
    """

    again = False
    context: Context

    def begin(self) -> None:
        """Start anew: the container was entered."""

    def choose(self) -> Turn:
        """Return what comes next."""
        raise NotImplementedError

    def over(self) -> None:
        """The container has ended, or was halted."""


class Cases(Rule):
    """A switch: the child whose literal equals the value.

    Args:
        value: computes it.
        cases: (child, literal), in order; the first that is equal wins.
        default: the child for every other value, or empty.
    """

    def __init__(self, value: Callable[[], Any], cases: Sequence[tuple[str, Any]], default: str):
        self.value, self.cases, self.default = value, cases, default

    def choose(self) -> Turn:
        """Compare."""
        value = self.value()
        child = next((name for name, literal in self.cases if same_literal(value, literal)), self.default)
        if child:
            return Turn(child)
        return Turn(None, "failure", Failure("no_case", f"no case is for {value!r}"))


class Passes(Rule):
    """A loop: the child again while a condition holds, `times` times at most."""

    again = True

    def __init__(self, child: str, condition: Condition | None, times: int | None):
        self.child, self.condition, self.times = child, condition, times
        self.done = 0

    def begin(self) -> None:
        """Count from the beginning."""
        self.done = 0

    def choose(self) -> Turn:
        """Look at the condition, then at the number of passes."""
        if self.condition is not None and not self.condition.holds():
            return Turn()
        if self.done == self.times:
            return Turn(None, "failure", Failure("loop_limit", f"it was still looping after {self.times} passes"))
        self.done += 1
        return Turn(self.child)
