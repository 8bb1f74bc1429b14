"""Random trees of py_trees' own classes that a task has an equivalent for."""

from __future__ import annotations

import operator
from random import Random

from py_trees import behaviours, composites, decorators, timers
from py_trees.behaviour import Behaviour
from py_trees.common import ComparisonExpression, OneShotPolicy, ParallelPolicy, Status

ENDS = (Status.SUCCESS, Status.FAILURE)


def make_leaf(random: Random, name: str) -> Behaviour:
    """Return a leaf that counts ticks, or works on keys of the blackboard, results of checks among them."""
    key, value = random.choice(("x", "y", "kept/1")), random.randint(0, 2)
    check = ComparisonExpression(key, value, random.choice((operator.eq, operator.ne, operator.lt, operator.ge)))
    others = [check, ComparisonExpression("y", 1, operator.le)]
    queue = random.choices((*ENDS, Status.RUNNING), k=random.randint(1, 4))
    return random.choice(
        (
            lambda: behaviours.Running(name),
            lambda: behaviours.Periodic(name, random.randint(1, 3)),
            lambda: behaviours.StatusQueue(name, queue, random.choice((None, *ENDS, Status.RUNNING))),
            lambda: behaviours.SuccessEveryN(name, random.randint(1, 3)),
            lambda: behaviours.TickCounter(name, random.randint(0, 3), random.choice(ENDS)),
            lambda: behaviours.SetBlackboardVariable(name, key, value, random.random() < 0.7),
            lambda: behaviours.SetBlackboardVariable(name, "z", value, True),
            lambda: behaviours.UnsetBlackboardVariable(name, key),
            lambda: behaviours.CheckBlackboardVariableExists(name, key),
            lambda: behaviours.CheckBlackboardVariableValue(name, check),
            lambda: behaviours.CheckBlackboardVariableValues(
                name, others, random.choice((operator.and_, operator.or_, operator.xor)), random.choice((None, "kept"))
            ),
            lambda: behaviours.CompareBlackboardVariables(name, "x", "y", random.choice((operator.eq, operator.gt))),
            lambda: behaviours.WaitForBlackboardVariable(name, key),
            lambda: behaviours.WaitForBlackboardVariableValue(name, check),
        )
    )()


def make_tree(random: Random, depth: int = 4, written: bool = False) -> Behaviour:
    """Return a tree; names repeat and hold what a task doesn't allow. `written`: only what py_trees' XML can say."""
    name = random.choice(("look", "look", "a.b/c", "take it", "1st", "größe", ""))
    if depth == 0 or random.random() < 0.15:
        if not written and random.random() < 0.7:
            return make_leaf(random, name)
        return random.choice(
            (
                lambda: behaviours.Success(name),
                lambda: behaviours.Failure(name),
                lambda: timers.Timer(name, duration=float(random.randint(1, 4))),
            )
        )()
    if random.random() < 0.55:
        children = [make_tree(random, depth - 1, written) for _ in range(random.choice((0, 1, 2, 2, 3, 4)))]
        policies = [
            ParallelPolicy.SuccessOnAll(synchronise=written or random.random() < 0.5),
            ParallelPolicy.SuccessOnOne(),
        ]
        if children and not written:
            chosen = random.sample(children, random.randint(1, len(children)))
            policies.append(ParallelPolicy.SuccessOnSelected(chosen, synchronise=random.random() < 0.5))
        policy = random.choice(policies)
        memory = random.random() < 0.5
        return random.choice(
            (
                lambda: composites.Sequence(name, memory, children),
                lambda: composites.Selector(name, memory, children),
                lambda: composites.Parallel(name, policy, children),
            )
        )()
    child = make_tree(random, depth - 1, written)
    times = random.choice((-1, 0, 1, 2, 3))
    if not written and random.random() < 0.5:
        return random.choice(
            (
                lambda: decorators.OneShot(name, child, random.choice([*OneShotPolicy])),
                lambda: decorators.Condition(name, child, random.choice(ENDS)),
                lambda: decorators.EternalGuard(name, child, lambda blackboard: blackboard.z <= 1, {"z"}),
            )
        )()
    return random.choice(
        (
            lambda: decorators.Retry(name, child, max(0, times)),
            lambda: decorators.Repeat(name, child, times),
            lambda: decorators.Timeout(name, child, float(random.randint(1, 6))),
            lambda: decorators.Inverter(name, child),
            lambda: decorators.FailureIsSuccess(name, child),
            lambda: decorators.SuccessIsFailure(name, child),
            lambda: decorators.PassThrough(name, child),
            lambda: decorators.Count(name, child),
            lambda: decorators.SuccessIsRunning(name, child),
            lambda: decorators.FailureIsRunning(name, child),
            lambda: decorators.RunningIsFailure(name, child),
        )
    )()
