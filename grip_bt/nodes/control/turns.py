"""Who is run next, in containers that choose: by a value, by a condition, by a list, by the clock.

A rule knows nothing of trees: the behaviours of a tree (`Chooser`) and the states of a machine ask the same rules.
"""

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


class Items(Rule):
    """A for_each: the child once for each item.

    Args:
        child: its name.
        items: returns the list.
        put: writes the item's variable.
    """

    again = True

    def __init__(self, child: str, items: Callable[[], Any], put: Callable[[Any], None]):
        self.child, self.items, self.put = child, items, put
        self.left: list[Any] | None = None

    def begin(self) -> None:
        """Forget the list of the last time."""
        self.left = None

    def choose(self) -> Turn:
        """Take the list as it is on entry, then one item after the other."""
        if self.left is None:
            items = self.items()
            if not isinstance(items, list | tuple):
                raise TypeError(f"`items` is {items!r}, a {type(items).__name__}, not a list")
            self.left = list(reversed(items))
        if not self.left:
            return Turn()
        self.put(self.left.pop())
        return Turn(self.child)


class Rest(Rule):
    """A cooldown: the child, unless it ended or was halted less than `seconds` [s] ago."""

    def __init__(self, child: str, seconds: float):
        self.child, self.seconds = child, seconds
        self.ready_at: float | None = None
        self.running = False

    def choose(self) -> Turn:
        """Look at the clock."""
        now = self.context.clock.now()
        if self.ready_at is not None and now < self.ready_at:
            return Turn(None, "failure", Failure("cooldown", f"{self.child} rests for {self.ready_at - now:g} s more"))
        self.running = True
        return Turn(self.child)

    def over(self) -> None:
        """Begin to rest, when the child has run."""
        if self.running:
            self.running, self.ready_at = False, self.context.clock.now() + self.seconds
