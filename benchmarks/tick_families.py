"""Trees to tick: families of one kind of node each, and a pick task as people write it with py_trees."""

from __future__ import annotations

import collections
from collections.abc import Callable
from typing import Any

from py_trees import behaviour, composites, decorators
from py_trees.common import ParallelPolicy, Status

S, F, R = Status.SUCCESS, Status.FAILURE, Status.RUNNING


class Succeeding(behaviour.Behaviour):
    def update(self) -> Status:
        return S


class Failing(behaviour.Behaviour):
    def update(self) -> Status:
        return F


class Running(behaviour.Behaviour):
    def update(self) -> Status:
        return R


def sequence(memory: bool) -> Callable[[list[Any]], Any]:
    return lambda kids: composites.Sequence("sequence", memory, kids)


def selector(kids: list[Any]) -> Any:
    return composites.Selector("selector", True, kids)


def parallel(kids: list[Any]) -> Any:
    return composites.Parallel("parallel", ParallelPolicy.SuccessOnAll(synchronise=True), kids)


def balanced(nodes: int, make: Callable[[list[Any]], Any], leaf: type, last: type | None = None, width: int = 5) -> Any:
    """Return a tree of about `nodes` nodes, made level by level; the leaf on the right may be another one."""
    inner, made = max(1, round((nodes - 1) / width)), 1
    shape: list[Any] = []
    rows = collections.deque([shape])
    while rows:
        row = rows.popleft()
        for _ in range(width):
            below: list[Any] | None = None
            if made < inner:
                below, made = [], made + 1
                rows.append(below)
            row.append(below)

    def build(row: list[Any], on_the_right: bool) -> Any:
        kids = []
        for i, below in enumerate(row):
            right = on_the_right and i == len(row) - 1
            if below is not None:
                kids.append(build(below, right))
            else:
                kids.append((last if right and last else leaf)("leaf"))
        return make(kids)

    return build(shape, True)


def flat(nodes: int) -> Any:
    return sequence(True)([Succeeding("leaf") for _ in range(nodes - 1)])


FULL: dict[str, Callable[[int], Any]] = {
    "sequence, flat": flat,
    "sequences": lambda n: balanced(n, sequence(True), Succeeding),
    "selectors": lambda n: balanced(n, selector, Failing),
    "reactive sequences": lambda n: balanced(n, sequence(False), Succeeding, Running),
    "parallels": lambda n: balanced(n, parallel, Succeeding),
}


def guarded(nodes: int) -> Any:
    """Conditions in front of what runs, all looked at in every tick."""
    return sequence(False)([*(Succeeding("condition") for _ in range(20)), rest_of(nodes - 21)])


def rest_of(nodes: int) -> Any:
    return balanced(nodes, sequence(True), Succeeding, Running)


STEADY: dict[str, Callable[[int], Any]] = {
    "steady sequences": rest_of,
    "20 conditions, then steady": guarded,
}


def pick_task() -> Any:
    """39 nodes: guards, a retry over candidates, time-outs, a watch beside the motion; the arm is approaching."""

    def motion(name: str, first: type = Succeeding) -> Any:
        steps = sequence(True)([Succeeding("plan"), first("move"), Succeeding("settle")])
        return decorators.Timeout(name, steps, 1e6)

    watch = composites.Parallel(
        "watch",
        ParallelPolicy.SuccessOnAll(synchronise=False),
        [motion("approach", Running), decorators.SuccessIsRunning("no contact", Succeeding("contact"))],
    )
    attempt = sequence(True)(
        [Succeeding("choose"), Succeeding("open hand"), watch, motion("descend"), Succeeding("close"), motion("lift")]
    )
    found = composites.Selector("found", True, [decorators.Inverter("none", Succeeding("look")), Succeeding("propose")])
    recover = sequence(True)([Succeeding("release"), motion("retreat")])
    pick = composites.Selector("pick or recover", True, [decorators.Retry("retry", attempt, 3), recover])
    return sequence(False)([Succeeding("no stop"), Succeeding("arm ready"), sequence(True)([found, pick])])
