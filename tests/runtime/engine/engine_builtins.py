"""Leaves of py_trees' own, over a blackboard of which each of two twin trees has its part."""

from __future__ import annotations

import itertools
import operator
import random
from types import SimpleNamespace
from typing import Any

from py_trees import behaviours
from py_trees.blackboard import Blackboard
from py_trees.common import Access, ComparisonExpression, Status

KEYS = ("x", "y", "pose")
OPERATORS = (operator.eq, operator.ne, operator.lt, operator.ge, lambda a, b: [a] if a == b else [])

LOGIC = (operator.and_, operator.or_, operator.xor, lambda a, b: bool(a) is bool(b))


def leaf_of_py_trees(name: str, rng: random.Random, board: str) -> Any:
    """Return a leaf that reads or writes variables of one part of the blackboard, or needs none."""
    queue = [rng.choice([Status.SUCCESS, Status.FAILURE, Status.RUNNING]) for _ in range(rng.randint(1, 4))]
    if rng.random() < 0.4:
        makes = [
            lambda: behaviours.Success(name),
            lambda: behaviours.Failure(name),
            lambda: behaviours.Running(name),
            lambda: behaviours.Dummy(name),
            lambda: behaviours.StatusQueue(name, queue, rng.choice([None, Status.RUNNING, Status.SUCCESS])),
            lambda: behaviours.SuccessEveryN(name, rng.randint(1, 4)),
            lambda: behaviours.Periodic(name, rng.randint(1, 3)),
            lambda: behaviours.TickCounter(name, rng.randint(0, 3), Status.SUCCESS),
        ]
        return rng.choice(makes)()
    return _over_a_variable(name, rng, board)


def _over_a_variable(name: str, rng: random.Random, board: str) -> Any:
    key, attribute = rng.choice(KEYS), rng.choice(["", "", ".at", ".at.z"])
    check = _check(rng, key + attribute)
    values = itertools.cycle([_value(rng, key) for _ in range(4)])
    value = (lambda: next(values)) if rng.random() < 0.7 else _value(rng, key)
    makes = [
        lambda: behaviours.CheckBlackboardVariableValue(name, check),
        lambda: behaviours.WaitForBlackboardVariableValue(name, check),
        lambda: behaviours.CheckBlackboardVariableExists(name, key + attribute),
        lambda: behaviours.WaitForBlackboardVariable(name, key + attribute),
        lambda: behaviours.SetBlackboardVariable(name, key, value, rng.random() < 0.8),
        lambda: behaviours.SetBlackboardVariable(name, "pose.at", value, True),
        lambda: behaviours.UnsetBlackboardVariable(name, key),
        lambda: behaviours.BlackboardToStatus(name, key),
        lambda: behaviours.BlackboardToStatus(name, "pose.status"),
        lambda: behaviours.CompareBlackboardVariables(name, key, rng.choice(KEYS), rng.choice(OPERATORS)),
        lambda: behaviours.CheckBlackboardVariableValues(
            name, [check, _check(rng), *(_check(rng) for _ in range(rng.randint(0, 1)))], rng.choice(LOGIC)
        ),
    ]
    leaf: Any = makes[rng.randrange(len(makes))]()
    client = leaf.blackboard
    for right, access in ((client.read, Access.READ), (client.write, Access.WRITE)):
        for absolute in list(right):
            client.register_key(key=absolute, access=access, remap_to=f"/{board}{absolute}")
            if rng.random() < 0.6:
                Blackboard.storage.setdefault(f"/{board}{absolute}", _value(rng, absolute[1:]))
    return leaf


def _check(rng: random.Random, variable: str = "") -> ComparisonExpression:
    variable = variable or rng.choice(KEYS) + rng.choice(["", "", ".at"])
    return ComparisonExpression(variable, rng.choice([0, 1, 2.0, lambda: 1]), rng.choice(OPERATORS))


def _value(rng: random.Random, key: str) -> Any:
    values: list[Any] = [0, 1, 1, 2, 0.5, "one", True, None]
    others = (
        [SimpleNamespace(at=1, status=Status.FAILURE)] if key == "pose" else [Status.SUCCESS, Status.RUNNING]
    )  # both trees share those
    return rng.choice(values + others)
