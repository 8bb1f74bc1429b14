"""A pick task as people write it with py_trees."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees import behaviour, composites, decorators
from py_trees.common import ParallelPolicy, Status

S, F, R = Status.SUCCESS, Status.FAILURE, Status.RUNNING


class Succeeding(behaviour.Behaviour):
    def update(self) -> Status:
        return S


class Running(behaviour.Behaviour):
    def update(self) -> Status:
        return R


def sequence(memory: bool) -> Callable[[list[Any]], Any]:
    return lambda kids: composites.Sequence("sequence", memory, kids)


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
