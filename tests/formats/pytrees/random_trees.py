"""Random trees of py_trees' own classes that a task has an equivalent for."""

from __future__ import annotations

from random import Random

from py_trees import behaviours, composites, decorators, timers
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy


def make_tree(random: Random, depth: int = 4, written: bool = False) -> Behaviour:
    """Return a tree; names repeat and hold what a task doesn't allow. `written`: only what py_trees' XML can say."""
    name = random.choice(("look", "look", "a.b/c", "take it", "1st", "größe", ""))
    if depth == 0 or random.random() < 0.15:
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
    return random.choice(
        (
            lambda: decorators.Retry(name, child, max(0, times)),
            lambda: decorators.Repeat(name, child, times),
            lambda: decorators.Timeout(name, child, float(random.randint(1, 6))),
            lambda: decorators.Inverter(name, child),
            lambda: decorators.FailureIsSuccess(name, child),
            lambda: decorators.SuccessIsFailure(name, child),
            lambda: decorators.PassThrough(name, child),
        )
    )()
