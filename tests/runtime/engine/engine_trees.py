"""Random trees of py_trees, twice from one seed."""

from __future__ import annotations

import random
from typing import Any

from engine_builtins import leaf_of_py_trees
from engine_leaves import (
    INVALID,
    Backwards,
    Ending,
    F,
    Log,
    LoggedInverter,
    LoggedParallel,
    LoggedSelector,
    LoggedSequence,
    Looking,
    Plain,
    R,
    Reckless,
    S,
    Seeing,
    Stopping,
    Ticking,
    Told,
)
from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import OneShotPolicy, ParallelPolicy

LEAVES = [Plain, Told, Told, Looking, Seeing, Seeing, Ending, Stopping, Ticking]
GUARDED = "guard"


class Maker:
    """Makes one tree.

    Args:
        seed: two makers with the same one make the same tree.
        log: what the nodes write to.
        calm: leaves run for long, so that the tree settles.
        wild: nodes with ticks and stops of their own, and those that raise.
    """

    def __init__(self, seed: int, log: Log, *, calm: bool = False, wild: bool = True):
        self.rng, self.log, self.calm, self.wild = random.Random(seed), log, calm, wild
        self.made = 0

    def name(self) -> str:
        self.made += 1
        return f"n{self.made}"

    def tree(self, depth: int = 4) -> Behaviour:
        draw = self.rng.random()
        if depth == 0 or draw < 0.28:
            return self.leaf()
        if draw < 0.75:
            return self.composite(depth)
        return self.decorator(depth)

    def leaf(self) -> Behaviour:
        rng = self.rng
        values: list[Any] = [S, S, S, F, F, R, R, R]
        if self.wild and rng.random() < 0.15:
            values += [INVALID, "bad", None, "raise"]
        script = [rng.choice(values) for _ in range(rng.randint(1, 6))]
        if self.calm:
            settled = rng.choice([S, F, R, R])
            script = [settled] * rng.randint(2, 25) + script
        if rng.random() < 0.25:
            return leaf_of_py_trees(self.name(), rng, self.log.board)
        kinds = LEAVES if self.wild else LEAVES[:6]
        return rng.choice(kinds)(self.name(), script, self.log)

    def row(self) -> list[Behaviour]:
        """Return leaves of one class that mostly go on together, as conditions do."""
        kind = self.rng.choice([Plain, Told, Looking])
        usual = self.rng.choice([S, S, F])
        scripts = [[usual] * self.rng.randint(1, 8) + [self.rng.choice([S, F, R])] for _ in range(4)]
        return [kind(self.name(), script, self.log) for script in scripts[: self.rng.randint(2, 4)]]

    def composite(self, depth: int) -> Behaviour:
        rng, name = self.rng, self.name()
        kids = [self.tree(depth - 1) for _ in range(rng.choice([0, 1, 2, 2, 3, 3, 4, 5]))]
        if rng.random() < 0.4:
            at = rng.randint(0, len(kids))
            kids[at:at] = self.row()
        memory, draw = rng.random() < 0.5, rng.random()
        if draw < 0.3:
            return composites.Sequence(name, memory, kids)
        if draw < 0.6:
            return composites.Selector(name, memory, kids)
        if draw < 0.75:
            return composites.Parallel(name, self.policy(kids), kids)
        node: Any
        if draw < 0.95 or not self.wild:
            make = rng.choice([LoggedSequence, LoggedSelector, LoggedParallel])
            node = make(name, self.policy(kids) if make is LoggedParallel else memory, kids)
        else:
            node = Backwards(name, kids) if rng.random() < 0.5 else Reckless(name, memory, kids)
        node.log = self.log
        return node

    def policy(self, kids: list[Behaviour]) -> Any:
        rng = self.rng
        draw, synchronise = rng.randrange(3), rng.random() < 0.5
        if draw == 0:
            return ParallelPolicy.SuccessOnAll(synchronise=synchronise)
        if draw == 1 or not kids:
            return ParallelPolicy.SuccessOnOne()
        chosen = rng.sample(kids, rng.randint(1, len(kids)))
        return ParallelPolicy.SuccessOnSelected(chosen, synchronise=synchronise)

    def decorator(self, depth: int) -> Behaviour:
        rng, name = self.rng, self.name()
        child = self.tree(depth - 1)
        makers = [
            lambda: decorators.Inverter(name, child),
            lambda: LoggedInverter(name, child),
            lambda: decorators.FailureIsSuccess(name, child),
            lambda: decorators.FailureIsRunning(name, child),
            lambda: decorators.SuccessIsFailure(name, child),
            lambda: decorators.SuccessIsRunning(name, child),
            lambda: decorators.RunningIsFailure(name, child),
            lambda: decorators.RunningIsSuccess(name, child),
            lambda: decorators.Retry(name, child, 2),
            lambda: decorators.Repeat(name, child, 2),
            lambda: decorators.Count(name, child),
            lambda: decorators.PassThrough(name, child),
            lambda: decorators.Condition(name, child, S),
            lambda: decorators.Timeout(name, child, 3.0),
            lambda: decorators.StatusToBlackboard(name, child, "status_of_child"),
            lambda: decorators.ForEach(name, child, "items", "item"),
            lambda: decorators.OneShot(name, child, rng.choice(list(OneShotPolicy))),
            lambda: decorators.EternalGuard(name, child, self.condition()),
        ]
        node: Any = makers[rng.randrange(len(makers) if self.wild else len(makers) - 2)]()
        node.log = self.log
        return node

    def condition(self) -> Any:
        results = [self.rng.random() < 0.7 for _ in range(5)]
        calls = iter(range(10**9))

        def holds() -> bool:
            return results[next(calls) % 5]

        return holds
