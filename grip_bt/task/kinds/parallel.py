"""All children at once; exits, rules and the policy decide over the ends of the children, in the document's order."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from math import prod
from operator import and_
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from grip_bt.base.frozen import FrozenDict

from ..parts import Meaning, Name, Shape
from .base import ChildEnds, Composite, End, Ended, Questions, Run, Shown, State, Stay, Step

FEW = 50
"""Combinations of children's ends up to which all ways of a parallel are listed: of three children of two ends, say."""


class ParallelRule(Shape):
    """A way in which a parallel ends, from how its children have ended; all of its conditions have to hold.

    Without conditions it is for the rest: it holds when everybody whom the parallel waits for has ended.
    """

    when: FrozenDict[Name, str | list[str]] = FrozenDict()
    """Child -> its outcome, or `outcome.code`, or a list of these."""
    at_least: int | None = Field(default=None, ge=1)
    """How many children have ended with the meaning `ends`."""
    ends: Meaning = "success"
    then: str
    """The outcome of the parallel."""

    def holds(self, there: Sequence[Ended], complete: bool) -> bool:
        """Tell whether it holds for the children that have ended; `complete`: no other child is waited for."""
        if not self.when and self.at_least is None:
            return complete
        labels = {end.child: {end.outcome, f"{end.outcome}.{end.code}"} for end in there}
        for child, said in self.when.items():
            if labels.get(child, set()).isdisjoint([said] if isinstance(said, str) else said):
                return False
        return sum(end.meaning == self.ends for end in there) >= (self.at_least or 0)

    def words(self) -> str:
        words = [f"{child}: {said if isinstance(said, str) else ' | '.join(said)}" for child, said in self.when.items()]
        if self.at_least is not None:
            words.append(f"{self.at_least} × {self.ends}")
        return ", ".join(words) or "else"


class Parallel(Composite):
    """All children at once.

    `all` succeeds when every child has succeeded and fails when one has failed; `any` succeeds when one has
    succeeded and fails when every child has failed. What is decided is decided after all children were ticked. Then
    `halt` interrupts the children that are still running, `ask` requests them to stop and waits for them, and `join`
    waits. Where there are `rules`, the first that matches decides, and `policy` only what none of them does.
    """

    rank: ClassVar[int] = 30
    sign: ClassVar[str] = "⇉"
    icon: ClassVar[str] = "M1.5 5h12M10.5 2l3 3-3 3M1.5 11h12M10.5 8l3 3-3 3"
    shown: ClassVar[Shown] = "Parallel"
    resets: ClassVar[bool] = True
    concurrent: ClassVar[bool] = True
    late_exits: ClassVar[bool] = True
    kind: Literal["parallel"]
    policy: Literal["all", "any"] = "all"
    rules: list[ParallelRule] = Field(default_factory=list)
    wait_for: Literal["all", "any"] | Annotated[int, Field(ge=1)] | list[Name] | None = None
    """Who has to have ended before anything is decided: all, one, this many, or these; then it is decided."""
    cancel: Literal["halt", "ask", "join"] = "halt"
    retick: bool = False
    """Children that have ended are activated again on every tick, until it is decided."""
    prompt: bool = False
    """Decided after each child rather than after all of them: the later ones are not ticked any more."""
    order: Literal["declared"] | None = None
    """`declared`: children may share variables, since they are ticked in their order."""

    @model_validator(mode="after")
    def _join_waits_for_all(self) -> Parallel:
        if self.cancel == "join" and self.wait_for not in (None, "all"):
            raise ValueError("`cancel: join` waits for all children; remove `wait_for`, or use `cancel: ask`")
        if self.prompt and self.cancel != "halt":
            raise ValueError("`prompt` halts what still runs at once; remove it, or use `cancel: halt`")
        if self.retick and (self.prompt or self.cancel != "halt"):
            raise ValueError("`retick` goes with `cancel: halt` and without `prompt`; remove it, or these")
        return self

    @property
    def reactive(self) -> bool:
        return self.retick

    @property
    def settles(self) -> bool:
        return True

    @property
    def blocking(self) -> bool:
        return self.joins

    @property
    def joins(self) -> bool:
        return self.cancel == "join" and self.order is None and bool(self.children)

    @property
    def may_ask(self) -> bool:
        return self.cancel == "ask"

    def explorable(self, ends: ChildEnds) -> bool:
        """Tell whether a few children have a few ends: these come in any order, of which there are many."""
        return prod(len(each) + 1 for each in ends) <= FEW

    def possible(self, ends: ChildEnds) -> tuple[set[str], int]:
        """Return what one child decides, and what all do; with rules, everything that they name."""
        if self.rules or self.wait_for is not None:
            named = {"success", "failure", *self.exits.values(), *(rule.then for rule in self.rules)}
            return named, len(ends)
        one, every = self._meanings
        found = {target for each in ends for _, target in each if target is not None}
        meanings = [{end.meaning for end, target in each if target is None} for each in ends]
        if any(one in each for each in meanings):
            found.add(one)
        if all(every in each for each in meanings):
            found.add(every)
        return found, len(ends)

    def flow(self, ends: ChildEnds, after: Callable[[int, int], Mapping[str, int]], state: int) -> dict[str, int]:
        """Return what is surely written: others may have been interrupted, unless they are waited for."""
        afters = [after(i, state) for i in range(len(ends))]
        joined = state
        for there in afters if self.cancel != "halt" else ():
            joined |= reduce(and_, there.values()) if there else 0
        if self.rules or self.wait_for is not None:  # who has ended then, only a run can tell
            return dict.fromkeys(self.possible(ends)[0], joined)
        one, every = self._meanings
        found: dict[str, int] = {}
        together, all_can = state, True
        for each, there in zip(ends, afters, strict=True):
            last: int | None = None
            for end, target in each:
                if end.outcome not in there:
                    continue
                written = there[end.outcome]
                if target is not None:
                    found[target] = found.get(target, written) & written
                elif end.meaning == one:
                    found[one] = found.get(one, written | joined) & (written | joined)
                else:
                    last = written if last is None else last & written
            all_can = all_can and last is not None
            together |= last or 0
        if all_can:
            found[every] = found.get(every, together) & together
        return found

    @property
    def _meanings(self) -> tuple[Meaning, Meaning]:
        """The meaning that decides when one child ends with it, and the one that takes all of them."""
        return ("failure", "success") if self.policy == "all" else ("success", "failure")

    def begin(self, state: State, q: Questions) -> Step:
        return Run(tuple(range(len(q.names))), None)

    def again(self, state: State, running: tuple[int, ...], q: Questions) -> Step:
        return Run(tuple(range(len(q.names))), state)

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        """Wait until all children were ticked, or with `prompt` decide at once."""
        return self.settle(state, q) if self.prompt else Stay(state)

    def settle(self, state: State, q: Questions) -> Step:
        """Decide; `state` is the end that was decided before, while others are asked to stop."""
        everybody = None not in q.ends
        if self.cancel == "join" and not everybody:
            return Stay(None)
        decided: End | None = state
        if decided is None:
            outcome = self._outcome(q)
            if outcome is None:
                return Stay(None)
            decided = End(outcome, _reason(q, outcome))
        if self.cancel == "ask" and not everybody:
            q.ask(f"{decided.outcome}, when the others have stopped")
            return Stay(decided)
        return decided

    def _outcome(self, q: Questions) -> str | None:
        there = [end for end in q.ends if end is not None]
        if not self._waited({end.child for end in there}, len(q.ends)):
            return None
        complete = self.wait_for is not None or len(there) == len(q.ends)
        taken = next(filter(None, map(q.exit, there)), None)
        if taken is not None:
            return taken
        matching = next((rule.then for rule in self.rules if rule.holds(there, complete)), None)
        if matching or self.rules and not complete:
            return matching
        return self._by_policy([end.meaning for end in there], complete)

    def _by_policy(self, meanings: list[str], complete: bool) -> str | None:
        one, every = self._meanings
        if not meanings and complete:
            return "success"
        return one if one in meanings else every if complete else None

    def _waited(self, ended: set[str], size: int) -> bool:
        need = self.wait_for
        if need is None or len(ended) == size:
            return True
        if isinstance(need, list):
            return set(need) <= ended
        return len(ended) >= (need if isinstance(need, int) else 1 if need == "any" else size)

    def settings(self) -> str:
        words = ["all must succeed" if self.policy == "all" else "first success ends it"]
        if self.rules:
            words = [f"{len(self.rules)} rules"]
        if self.wait_for is not None:
            words.append(f"waits for {', '.join(self.wait_for) if isinstance(self.wait_for, list) else self.wait_for}")
        return ", ".join([*words, self.cancel])

    def lines(self) -> list[str]:
        return [f"{rule.words()} ⇥ {rule.then}" for rule in self.rules]


def _reason(q: Questions, outcome: str) -> object:
    """Return why it failed: the failure of the first child that accounts for the outcome."""
    there = [end for end in q.ends if end is not None]
    accounts = [e for e in there if q.exit(e) == outcome] or [e for e in there if e.meaning == "failure"]
    return accounts[0].failure if accounts else None
