"""BiTRRT: two trees that prefer configurations far from what they could touch (Devaurs, Simeon and Cortes 2013).

The cost of a configuration is how close anything is, in steps of clearance: a batched check with a margin tells more
cheaply that a clearance is kept than a distance computation would. Steps to a higher cost are taken by chance, the
more rarely the cooler the search is; it warms up while it is stuck.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grip_bt.base.arrays import Array, Configuration, Path

from ..collision import CollisionChecker
from .paths import EdgeCheck, interpolated
from .trees import Tree, joined, stepped

CLEARANCES = (0.08, 0.04, 0.02, 0.01)
"""A configuration costs a quarter for each of these distances [m] that isn't kept all around."""
STEP = 0.5
"""Longest edge of a tree [rad]."""
_SAMPLING = 0.1
_COLD = 0.02
_WARMING = 0.1
"""Each refusal makes the search warmer by 2 to the power of this, each acceptance of a rise cooler by the rise."""
_COOLING = 0.25


def costs(checker: CollisionChecker, configurations: Array) -> Array:
    """Return the cost of configurations, shape (k, n), in [0, 1]; shape (k,). Collisions aren't looked at."""
    result = np.ones(len(configurations))
    tight = np.arange(len(configurations))
    for k, clearance in enumerate(CLEARANCES):
        clear = checker.clear_each(configurations[tight], clearance)
        result[tight[clear]] = k / len(CLEARANCES)
        tight = tight[~clear]
        if not len(tight):
            break
    return result


def highest_cost(checker: CollisionChecker, path: Path) -> float:
    """Return the highest cost on the straight motions through the rows of a path, shape (k, n)."""
    return float(costs(checker, interpolated(path, _SAMPLING)).max())


def bitrrt(
    checker: CollisionChecker,
    edge_free: EdgeCheck,
    start: Configuration,
    goal: Configuration,
    rng: np.random.Generator,
    over: Callable[[], bool],
) -> Path | None:
    """Return a way that keeps clear of things where it can, shape (k, n), or None when `over` says so."""
    limits, extend = checker.chain.limits, _Extension(checker, edge_free, rng)
    return joined(start, goal[None, :], lambda: rng.uniform(limits.lower, limits.upper), extend, over)


class _Extension:
    """One step of a tree, with the transition test; the original's control of refinement is left out."""

    def __init__(self, checker: CollisionChecker, edge_free: EdgeCheck, rng: np.random.Generator):
        self._checker, self._edge_free, self._rng = checker, edge_free, rng
        self._temperature = _COLD
        self._costs: dict[tuple[int, int], float] = {}

    def __call__(self, tree: Tree, index: int, towards: Configuration) -> int | None:
        one = tree.at(index)
        other = stepped(one, towards, STEP)
        cost = float(costs(self._checker, other[None, :])[0])
        if not self._accepted(self._cost(tree, index), cost) or not self._edge_free(one, other):
            return None
        added = tree.add(other, index)
        self._costs[id(tree), added] = cost
        return added

    def _cost(self, tree: Tree, index: int) -> float:
        key = (id(tree), index)
        if key not in self._costs:
            self._costs[key] = float(costs(self._checker, tree.at(index)[None, :])[0])
        return self._costs[key]

    def _accepted(self, before: float, after: float) -> bool:
        """Take every step that gets no closer to things, others with a chance that falls with the rise."""
        rise = after - before
        if rise <= 0:
            return True
        if self._rng.random() < np.exp(-rise / self._temperature):
            self._temperature = max(_COLD, self._temperature / 2 ** (rise / _COOLING))
            return True
        self._temperature *= 2**_WARMING
        return False
