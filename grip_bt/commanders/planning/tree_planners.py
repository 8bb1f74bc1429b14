"""Tree planners of our own (after Kuffner and LaValle 2000): BiTRRT keeps clear of things, CBiRRT to a constraint.

What a planner adds is how a tree is extended by one step: with projection it is CBiRRT, with a transition test BiTRRT.
The cost of a configuration is how close anything is, in steps of clearance. Steps to a higher cost are taken by chance,
the more rarely the cooler the search is; it warms up while it is stuck.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grip_bt.base.arrays import Array, Configuration, Path
from grip_bt.base.values import PathConstraint

from ..kinematics.collision import CollisionChecker
from .paths import EdgeCheck, interpolated, kept, length, projected


class Tree:
    """Configurations, each with the one that it was reached from."""

    def __init__(self, root: Configuration):
        self._rows = np.empty((64, len(root)))
        self._parents: list[int] = []
        self.add(root, -1)

    def __len__(self) -> int:
        return len(self._parents)

    def add(self, q: Configuration, parent: int) -> int:
        """Add a configuration and return its index."""
        index = len(self._parents)
        if index == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._rows[index] = q
        self._parents.append(parent)
        return index

    def at(self, index: int) -> Configuration:
        """Return a configuration, shape (n,)."""
        return self._rows[index]

    def nearest(self, q: Configuration) -> int:
        """Return the index of the configuration nearest to `q`."""
        offsets = self._rows[: len(self)] - q
        return int(np.argmin(np.einsum("ij,ij->i", offsets, offsets)))

    def branch(self, index: int) -> Path:
        """Return the way from the root to a configuration, shape (k, n)."""
        rows = []
        while index >= 0:
            rows.append(self.at(index))
            index = self._parents[index]
        return np.stack(rows[::-1])


Extend = Callable[[Tree, int, Configuration], int | None]
"""`(tree, from, towards) -> index of the configuration that was added`, or None when there is no way on."""


def joined(
    start: Configuration,
    goal: Configuration,
    sample: Callable[[], Configuration],
    extend: Extend,
    over: Callable[[], bool],
    close: float = 1e-6,
) -> Path | None:
    """Return a way from `start` to `goal`, shape (k, n), or None when time is over.

    Args:
        sample: returns random configurations to grow towards.
        extend: adds one step to a tree.
        over: asked after each step; True ends it.
        close: trees have met when they are this close, in every joint.
    """
    growing, waiting, forward = Tree(start), Tree(goal), True
    while not over():
        target = sample()
        reached = extend(growing, growing.nearest(target), target)
        meeting = None if reached is None else grown_towards(waiting, growing.at(reached), extend, over, close)
        if reached is not None and meeting is not None:
            way = np.concatenate([growing.branch(reached), waiting.branch(meeting)[::-1][1:]])
            return way if forward else way[::-1]
        growing, waiting, forward = waiting, growing, not forward
    return None


def grown_towards(
    tree: Tree, target: Configuration, extend: Extend, over: Callable[[], bool], close: float
) -> int | None:
    """Extend a tree step by step as far as it goes; return the last index if that is the target."""
    index = tree.nearest(target)
    while not over():
        if np.abs(tree.at(index) - target).max() < close:
            return index
        step = extend(tree, index, target)
        if step is None:
            return None
        index = step
    return None


def stepped(one: Configuration, towards: Configuration, step: float) -> Configuration:
    """Return the configuration at most `step` [rad] (Euclidean) on the straight way from `one` to `towards`."""
    way = towards - one
    distance = float(np.linalg.norm(way))
    return np.array(towards) if distance <= step else one + way * (step / distance)


CLEARANCES = (0.08, 0.04, 0.02, 0.01)
"""A configuration costs a quarter for each of these distances [m] that isn't kept all around."""
BITRRT_STEP = 0.5
"""Longest edge of a tree [rad]."""
_COST_SAMPLING = 0.1
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
    return float(costs(checker, interpolated(path, _COST_SAMPLING)).max())


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
    return joined(start, goal, lambda: rng.uniform(limits.lower, limits.upper), extend, over)


class _Extension:
    """One step of a tree, with the transition test; the original's control of refinement is left out."""

    def __init__(self, checker: CollisionChecker, edge_free: EdgeCheck, rng: np.random.Generator):
        self._checker, self._edge_free, self._rng = checker, edge_free, rng
        self._temperature = _COLD

    def __call__(self, tree: Tree, index: int, towards: Configuration) -> int | None:
        one = tree.at(index)
        other = stepped(one, towards, BITRRT_STEP)
        before, after = costs(self._checker, np.stack([one, other])).tolist()
        return tree.add(other, index) if self._accepted(before, after) and self._edge_free(one, other) else None

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


CBIRRT_STEP = 0.15
"""Longest step before its projection [rad]."""
_ROUNDS = 60
_SAMPLING = 0.03


def cbirrt(
    checker: CollisionChecker,
    edge_free: EdgeCheck,
    constraint: PathConstraint,
    start: Configuration,
    goal: Configuration,
    rng: np.random.Generator,
    over: Callable[[], bool],
) -> Path | None:
    """Return a short free way that keeps to a constraint, shape (k, n), or None when `over` says so."""
    chain = checker.chain

    def extend(tree: Tree, index: int, towards: Configuration) -> int | None:
        one = tree.at(index)
        other = projected(constraint, chain, stepped(one, towards, CBIRRT_STEP))
        # A projection may slide back; then the tree would grow on the spot for ever.
        if other is None or np.linalg.norm(towards - other) >= np.linalg.norm(towards - one):
            return None
        edge = np.stack([one, other])
        if not kept(constraint, chain, interpolated(edge, _SAMPLING), slack=1e-3) or not edge_free(one, other):
            return None
        return tree.add(other, index)

    limits = chain.limits
    path = joined(start, goal, lambda: rng.uniform(limits.lower, limits.upper), extend, over, close=1e-3)
    return None if path is None else _shortened(path, extend, rng, over)


def _shortened(
    path: Path,
    extend: Callable[[Tree, int, Configuration], int | None],
    rng: np.random.Generator,
    over: Callable[[], bool],
) -> Path:
    """Replace parts of the path by what one tree grows from their beginning to their end, where that is shorter."""
    for _ in range(_ROUNDS):
        if len(path) < 3 or over():
            break
        i, j = np.sort(rng.choice(len(path), 2, replace=False))
        tree = Tree(path[i])
        end = grown_towards(tree, path[j], extend, over, close=1e-3) if j > i + 1 else None
        if end is not None:
            piece: Array = np.concatenate([tree.branch(end)[:-1], path[j : j + 1]])
            if length(piece) < length(path[i : j + 1]):
                path = np.concatenate([path[:i], piece, path[j + 1 :]])
    return path
